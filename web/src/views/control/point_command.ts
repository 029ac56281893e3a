// SPDX-License-Identifier: Apache-2.0
// A point as it was typed, as a command.

export type Complaint = "no_name" | "bad_name" | "bad_number" | "bad_sigma" | "lonely_sigma" | "missing_sigma";

const numberIn = (text: string): number => (/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text) ? Number(text) : NaN);

/** What is not given is "-"; without any standard deviation the server takes its own. */
export function pointCommand(name: string, role: string, coordinates: readonly string[], sigmas: readonly string[]): { words: string[] } | { error: Complaint } {
  const known = name.trim();
  if (!known) return { error: "no_name" };
  if (known.length > 200 || known === "-") return { error: "bad_name" };
  const [e, s] = [coordinates.map((text) => text.trim()), sigmas.map((text) => text.trim())];
  if (e.some((text) => text && !Number.isFinite(numberIn(text)))) return { error: "bad_number" };
  if (s.some((text) => text && !(numberIn(text) > 0))) return { error: "bad_sigma" };
  if (s.some((text, axis) => text && !e[axis])) return { error: "lonely_sigma" };
  // Without one of its own beside others that have one, a coordinate would count as not known.
  if (s.some(Boolean) && e.some((text, axis) => text && !s[axis])) return { error: "missing_sigma" };
  const words = ["point", known, role, ...e.map((text) => text || "-")];
  return { words: s.some(Boolean) ? [...words, ...s.map((text) => text || "-")] : words };
}

// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them, with their units; "–" for what is not known.
import type { Language } from "./words.svelte";

export const unknown = "–";

const formats = new Map<string, Intl.NumberFormat>();

function format(language: Language, decimals: number, grouping: boolean): Intl.NumberFormat {
  const key = `${language} ${decimals} ${grouping}`;
  let found = formats.get(key);
  if (!found) {
    found = new Intl.NumberFormat(language, { minimumFractionDigits: decimals, maximumFractionDigits: decimals, useGrouping: grouping });
    formats.set(key, found);
  }
  return found;
}

/** A number with as many decimals; a minus that is one (not a hyphen). */
export function fixed(value: number | null | undefined, decimals: number, language: Language, grouping = false): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return unknown;
  return format(language, decimals, grouping).format(value).replace("-", "−");
}

export const count = (value: number, language: Language): string => fixed(value, 0, language, true);

export function bytes(value: number, language: Language): string {
  if (value < 1e6) return `${fixed(Math.max(value / 1e3, 0.1), value < 1e4 ? 1 : 0, language)} kB`;
  return value < 1e9 ? `${fixed(value / 1e6, 1, language)} MB` : `${fixed(value / 1e9, 2, language)} GB`;
}

export function duration(seconds: number, language: Language): string {
  if (seconds < 10) return `${fixed(seconds, 1, language)} s`;
  if (seconds < 100) return `${fixed(seconds, 0, language)} s`;
  return seconds < 6000 ? `${fixed(seconds / 60, 0, language)} min` : `${fixed(seconds / 3600, 1, language)} h`;
}

/** "12 m", "0.034 m": as many decimals as a hundredth of it shows, at most to a tenth of a millimetre. */
export function length(metres: number | null | undefined, language: Language): string {
  if (metres === null || metres === undefined || !Number.isFinite(metres)) return unknown;
  const size = Math.abs(metres);
  const decimals = size >= 100 ? 1 : size >= 10 ? 2 : size >= 0.1 ? 3 : 4;
  return `${fixed(metres, decimals, language)} m`;
}

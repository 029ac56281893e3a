// SPDX-License-Identifier: Apache-2.0
// Figures of a step as rows of a table.

export interface Figure {
  name: string;
  /** Empty: a number without one, or no number. */
  unit: string;
  /** A number, a text, or several of one kind. */
  values: (number | string | boolean | null)[];
}

const units: Record<string, string> = {
  m: "m", px: "px", deg: "°", grey: "grey levels", s: "s", um: "µm", mm: "mm", ppm: "ppm", mb: "MB", m2: "m²", arcsec: "″", sigmas: "σ",
};
const mostValues = 12;

/** A unit is the last word of a name: "mean_reprojection_px". */
export function parted(name: string): { name: string; unit: string } {
  const at = name.lastIndexOf("_");
  const unit = at < 0 ? undefined : units[name.slice(at + 1)];
  return unit ? { name: name.slice(0, at), unit } : { name, unit: "" };
}

const isPlain = (value: unknown): value is number | string | boolean | null =>
  value === null || ["number", "string", "boolean"].includes(typeof value);

/** Findings stand elsewhere; empty lists and lists of objects or of very many say nothing in a table. */
export function rowsOf(figures: Record<string, unknown>, within = ""): Figure[] {
  const rows: Figure[] = [];
  for (const [key, value] of Object.entries(figures)) {
    if (key === "findings") continue;
    const { name, unit } = parted(key);
    const full = (within + name).replaceAll("_", " ");
    if (isPlain(value)) rows.push({ name: full, unit, values: [value] });
    else if (Array.isArray(value)) {
      if (value.length && value.length <= mostValues && value.every(isPlain)) rows.push({ name: full, unit, values: value });
    } else if (typeof value === "object") rows.push(...rowsOf(value as Record<string, unknown>, `${within}${key}: `));
  }
  return rows;
}

/** As many digits as a reader wants of any size: 35165, 0.1180, 12.45. */
export function decimalsOf(value: number): number {
  if (Number.isInteger(value)) return 0;
  const size = Math.abs(value);
  return size >= 100 ? 1 : size >= 10 ? 2 : size >= 1 ? 3 : Math.min(6, 3 - Math.floor(Math.log10(size)));
}

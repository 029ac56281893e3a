// SPDX-License-Identifier: Apache-2.0
// Figures of vertices: which there are of so many, and how they are written.
import type { FigureKind, MeasuredFigure } from "../../lib/drawing_types";
import { fixed, unknown } from "../../lib/format";
import type { Language } from "../../lib/words.svelte";

export function kindsOf(count: number, isArea: boolean): FigureKind[] {
  if (count < 2) return [];
  if (count === 2) return ["distance", "plan_distance", "height_difference", "slope"];
  return [...(count === 3 ? (["angle"] as const) : []), "length", ...(isArea ? (["area", "plan_area"] as const) : [])];
}

const units: Record<MeasuredFigure["unit"], string> = { m: "m", m2: "m²", rad: "°" };

/** As many decimals as show two digits of the standard deviation, at most five. */
export function figureText(figure: MeasuredFigure, language: Language): string {
  const factor = figure.unit === "rad" ? 180 / Math.PI : 1;
  const sigma = figure.sigma === null ? null : figure.sigma * factor;
  const decimals = sigma ? Math.min(5, Math.max(0, 1 - Math.floor(Math.log10(sigma)))) : 3;
  return `${fixed(figure.value * factor, decimals, language)} ± ${sigma === null ? unknown : fixed(sigma, decimals, language)} ${units[figure.unit]}`;
}

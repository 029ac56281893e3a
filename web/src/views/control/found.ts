// SPDX-License-Identifier: Apache-2.0
// Targets that were found in photographs, and the points that they are.
import type { Place, Vector2 } from "../../lib/types";

/** A mark that is offered. */
export interface FoundMark {
  point: string;
  image: number;
  file: string;
  pixel: Vector2;
  sigma_px: number;
  kind: string;
  /** From the predicted position; nothing: none is known. */
  off_px: number | undefined;
  /** Beyond what the predicted position is uncertain by. */
  isFar: boolean;
}

/** The point that is called by the number of a tag, else the only one whose name ends in it (as `collinea tags --control`). */
export function pointOfTag(names: readonly string[], number: number): string | undefined {
  if (names.includes(String(number))) return String(number);
  const ends = names.filter((name) => {
    const digits = /\d+$/.exec(name)?.[0];
    return digits !== undefined && Number(digits) === number;
  });
  return ends.length === 1 ? ends[0] : undefined;
}

/** How far a target lies from where it was predicted, and whether that is beyond three standard deviations in the worst direction and a pixel of measuring. */
export function offOf(pixel: Vector2, place: Place | undefined): { off_px: number | undefined; isFar: boolean } {
  if (!place?.ellipse) return { off_px: undefined, isFar: false };
  const off_px = Math.hypot(pixel[0] - place.pixel[0], pixel[1] - place.pixel[1]);
  return { off_px, isFar: off_px > 3 * place.ellipse.major_px + 1 };
}

// SPDX-License-Identifier: Apache-2.0
// Geometry of the map: plain values in map coordinates [m].
import { isInside } from "../../lib/ring";
import type { ImageInfo, Vector2 } from "../../lib/types";

export interface Seen {
  image: ImageInfo;
  /** In plan, from its projection centre; null: that is not known. */
  distance_m: number | null;
}

/** The photographs in whose footprint a place lies, the nearest first. */
export function seenBy(images: readonly ImageInfo[], place: Vector2): Seen[] {
  return images
    .filter((image) => image.footprint !== null && isInside(image.footprint, ...place))
    .map((image) => ({ image, distance_m: image.position ? Math.hypot(image.position[0] - place[0], image.position[1] - place[1]) : null }))
    .sort((a, b) => (a.distance_m ?? Infinity) - (b.distance_m ?? Infinity) || a.image.id - b.image.id);
}

/** The largest of 1, 2, 5 times a power of ten that is not above a value; 1 of what is no positive number. */
export function roundFactor(value: number): number {
  if (!(value > 0) || !Number.isFinite(value)) return 1;
  const power = 10 ** Math.floor(Math.log10(value) + 1e-12);
  for (const digit of [5, 2]) if (digit * power <= value * (1 + 1e-9)) return digit * power;
  return power;
}

export interface Axes {
  /** Semi-axes of the ellipse of one standard deviation, as the standard deviations are. */
  major: number;
  minor: number;
  /** Of the major axis, from east towards north [rad]. */
  angle: number;
}

/** Of two standard deviations and their covariance. */
export function ellipseOf(sigma_e: number, sigma_n: number, covariance: number): Axes {
  const [a, b] = [sigma_e * sigma_e, sigma_n * sigma_n];
  const mean = (a + b) / 2;
  const spread = Math.hypot((a - b) / 2, covariance);
  return { major: Math.sqrt(mean + spread), minor: Math.sqrt(Math.max(0, mean - spread)), angle: Math.atan2(2 * covariance, a - b) / 2 };
}

/** The middle one; nothing of nothing. */
export function median(values: readonly number[]): number | undefined {
  const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
  return sorted[sorted.length >> 1];
}

// SPDX-License-Identifier: Apache-2.0
// Whether points lie where the block is, and what may be wrong where they do not.
import type { Vector2 } from "./types";

export type Bounds = readonly [number, number, number, number];

/** From a rectangle (west, south, east, north) [m]; 0: within. */
export const distanceTo = ([west, south, east, north]: Bounds, [e, n]: Vector2): number =>
  Math.hypot(Math.max(west - e, 0, e - east), Math.max(south - n, 0, n - north));

export interface Fit {
  /** Of each point: within the block, or no farther from it than half its diagonal. */
  isNear: boolean[];
  near: number;
  /** The least distance of one that is far [m]; 0: none is. */
  least_m: number;
  /** With easting and northing exchanged more would be near. */
  isSwapped: boolean;
  /** They look like degrees, and the block is in metres. */
  isDegrees: boolean;
}

export function fitOf(points: readonly Vector2[], bounds: Bounds): Fit {
  const reach = Math.hypot(bounds[2] - bounds[0], bounds[3] - bounds[1]) / 2;
  const isNear = points.map((point) => distanceTo(bounds, point) <= reach);
  const near = isNear.filter(Boolean).length;
  const far = points.filter((_, at) => !isNear[at]).map((point) => distanceTo(bounds, point));
  const exchanged = points.filter(([e, n]) => distanceTo(bounds, [n, e]) <= reach).length;
  const isDegrees = points.length > 0 && near === 0 && points.every(([e, n]) => Math.abs(e) <= 180 && Math.abs(n) <= 180);
  return { isNear, near, least_m: far.length ? Math.min(...far) : 0, isSwapped: exchanged > near, isDegrees };
}

/** A CRS as proj4 takes it: a text for proj4 itself, UTM and degrees of WGS 84 and ETRS89; nothing of others. */
export function projOf(crs: string): string | undefined {
  const text = crs.trim();
  if (text.startsWith("+proj=")) return text;
  const words = /^wgs ?84 utm (\d+) ?([ns])$/i.exec(text);
  if (words) return utm(Number(words[1]), words[2]?.toUpperCase() === "S", "+datum=WGS84");
  const code = Number(/^epsg:\s*(\d+)$/i.exec(text)?.[1] ?? NaN);
  if (code === 4326 || code === 4979) return "+proj=longlat +datum=WGS84 +no_defs";
  if (code > 32600 && code <= 32660) return utm(code - 32600, false, "+datum=WGS84");
  if (code > 32700 && code <= 32760) return utm(code - 32700, true, "+datum=WGS84");
  if (code >= 25828 && code <= 25838) return utm(code - 25800, false, "+ellps=GRS80 +towgs84=0,0,0");
  return undefined;
}

const utm = (zone: number, isSouth: boolean, datum: string): string | undefined =>
  zone >= 1 && zone <= 60 ? `+proj=utm +zone=${zone}${isSouth ? " +south" : ""} ${datum} +units=m +no_defs` : undefined;

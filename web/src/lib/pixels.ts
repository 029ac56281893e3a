// SPDX-License-Identifier: Apache-2.0
// Pixels of a photograph and where they are shown. Pixels: the centre of the upper-left pixel is (0.5, 0.5), x right, y down. View
// coordinates, those of OpenLayers: one unit is a native pixel, x right, y up, the origin at the outer upper-left corner.
import type { ImageInfo, Vector2 } from "./types";

export const viewOf = ([x, y]: Vector2): Vector2 => [x, 0 - y];
export const pixelOf = ([x, y]: readonly number[]): Vector2 => [x ?? NaN, 0 - (y ?? NaN)];

/** Native pixels of one pixel of each level of the pyramid, the coarsest first. */
export const resolutionsOf = (levels: number): number[] => Array.from({ length: levels }, (_, z) => 2 ** (levels - 1 - z));

/** The coarsest level that is no coarser than the screen, for `scale` pixels of the screen per native one. */
export function levelFor(levels: number, scale: number): number {
  const wanted = levels - 1 + Math.ceil(Math.log2(Math.max(scale, 1e-9)) - 1e-9);
  return Math.min(levels - 1, Math.max(0, wanted));
}

export interface TileIndex {
  z: number;
  x: number;
  y: number;
}

/** The tiles of a level that cover a window of native pixels (left, top, right, bottom), row by row; none beyond the photograph. */
export function tilesOf(image: ImageInfo, z: number, window: readonly [number, number, number, number], tile_px: number): TileIndex[] {
  const side = tile_px * 2 ** (image.levels - 1 - z);
  const [left, top, right, bottom] = [Math.max(0, window[0]), Math.max(0, window[1]), Math.min(image.width, window[2]), Math.min(image.height, window[3])];
  const tiles: TileIndex[] = [];
  if (!(left < right && top < bottom)) return tiles;
  for (let y = Math.floor(top / side); y * side < bottom; ++y)
    for (let x = Math.floor(left / side); x * side < right; ++x) tiles.push({ z, x, y });
  return tiles;
}

/** Whether a pixel lies in a photograph, its rim included. */
export const isInside = (image: ImageInfo, [x, y]: Vector2): boolean => x >= 0 && y >= 0 && x <= image.width && y <= image.height;

/** How a window of native pixels about a pixel lies on a piece of screen. */
export interface Window {
  centre: Vector2;
  /** Pixels of the screen per native one. */
  scale: number;
  width: number;
  height: number;
}

export const screenOf = (window: Window, [x, y]: Vector2): Vector2 => [
  (x - window.centre[0]) * window.scale + window.width / 2,
  (y - window.centre[1]) * window.scale + window.height / 2,
];

/** The native pixels that a window shows: left, top, right, bottom. */
export const boundsOf = ({ centre, scale, width, height }: Window): [number, number, number, number] => [
  centre[0] - width / 2 / scale,
  centre[1] - height / 2 / scale,
  centre[0] + width / 2 / scale,
  centre[1] + height / 2 / scale,
];

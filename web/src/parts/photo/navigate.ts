// SPDX-License-Identifier: Apache-2.0
// Keys that move a photograph, the same in all views.
import type { PhotoMap } from "./photo_map.svelte";

const part = 0.12; // of the view, by one key

const moves: Record<string, (map: PhotoMap) => void> = {
  "0": (map) => map.fit(),
  f: (map) => map.fit(),
  "1": (map) => map.zoomTo(1),
  "2": (map) => map.zoomTo(2),
  "4": (map) => map.zoomTo(4),
  "8": (map) => map.zoomTo(8),
  "+": (map) => map.zoomBy(2),
  "=": (map) => map.zoomBy(2),
  "-": (map) => map.zoomBy(0.5),
  w: (map) => map.pan(0, -part),
  a: (map) => map.pan(-part, 0),
  s: (map) => map.pan(0, part),
  d: (map) => map.pan(part, 0),
  ArrowUp: (map) => map.pan(0, -part),
  ArrowLeft: (map) => map.pan(-part, 0),
  ArrowDown: (map) => map.pan(0, part),
  ArrowRight: (map) => map.pan(part, 0),
};

/** Whether it was one of these keys; letters in lower case. */
export function navigate(map: PhotoMap, key: string): boolean {
  const move = Object.hasOwn(moves, key) ? moves[key] : undefined;
  move?.(map);
  return move !== undefined;
}

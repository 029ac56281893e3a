// SPDX-License-Identifier: Apache-2.0
// What lies in a ring: the same law as collinea/geometry/polygon.h.
import type { Vector2 } from "./types";

/** Whether a position lies inside a ring, closed by itself: behind an odd number of sides. Of two sides that meet at a height one counts, or both or none do. */
export function isInside(ring: readonly Vector2[], x: number, y: number): boolean {
  let inside = false;
  for (let i = 0; i < ring.length; ++i) {
    const [a, b] = [ring[i] as Vector2, ring[i + 1 < ring.length ? i + 1 : 0] as Vector2];
    if (a[1] > y !== b[1] > y && a[0] + ((y - a[1]) / (b[1] - a[1])) * (b[0] - a[0]) <= x) inside = !inside;
  }
  return inside;
}

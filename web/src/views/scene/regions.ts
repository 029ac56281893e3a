// SPDX-License-Identifier: Apache-2.0
// Edits of the cloud as the page applies them to what it shows: the same law as collinea/cloud/cloud_edits.h.
import type { CloudRegion, Vector2 } from "../../lib/types";

/** Behind an odd number of sides; of two sides that meet at a height one counts, or both or none do. */
export function isInRing(ring: Vector2[], e: number, n: number): boolean {
  let inside = false;
  for (let i = 0; i < ring.length; ++i) {
    const [a, b] = [ring[i] as Vector2, ring[(i + 1) % ring.length] as Vector2];
    if (a[1] > n !== b[1] > n && a[0] + ((n - a[1]) / (b[1] - a[1])) * (b[0] - a[0]) <= e) inside = !inside;
  }
  return inside;
}

export const isInRegion = (region: CloudRegion, e: number, n: number, h: number): boolean =>
  (region.low_m === null || h >= region.low_m) && (region.high_m === null || h <= region.high_m) && isInRing(region.ring, e, n);

/** The class that a point has after all edits; -1: it is removed. */
export function editedClass(regions: CloudRegion[], own: number, e: number, n: number, h: number): number {
  let now = own;
  for (const region of regions) {
    const inside = isInRegion(region, e, n, h);
    if (region.action === "classify") {
      if (inside) now = region.class ?? now;
    } else if (inside === (region.action === "cut")) {
      return -1;
    }
  }
  return now;
}

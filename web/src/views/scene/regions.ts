// SPDX-License-Identifier: Apache-2.0
// Edits of the cloud as the page applies them to what it shows: the same law as collinea/cloud/cloud_edits.h.
import { isInside } from "../../lib/ring";
import type { CloudRegion } from "../../lib/types";

export const isInRegion = (region: CloudRegion, e: number, n: number, h: number): boolean =>
  (region.low_m === null || h >= region.low_m) && (region.high_m === null || h <= region.high_m) && isInside(region.ring, e, n);

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

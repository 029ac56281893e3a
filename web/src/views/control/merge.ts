// SPDX-License-Identifier: Apache-2.0
import type { Control, ControlPoint, Mark } from "../../lib/types";

/** What the whole block says now of marks that are where it had them; of others nothing is known. */
function withTests(mark: Mark, now: ControlPoint): Mark {
  const tested = now.marks.find((one) => one.image === mark.image && one.pixel[0] === mark.pixel[0] && one.pixel[1] === mark.pixel[1]);
  const { residual_px = null, w = null, redundancy = null, detectable_px = null } = tested ?? {};
  return { ...mark, residual_px, w, redundancy, detectable_px };
}

/** Points as they are given and marked, with differences and tests of the whole block as it is now instead of those of the last adjustment. */
export function asNow(control: Control | undefined, now: Control | undefined): ControlPoint[] {
  const points = control?.points ?? [];
  if (!now) return points;
  const known = new Map(now.points.map((point) => [point.name, point]));
  return points.map((point) => {
    const one = known.get(point.name);
    if (!one) return point;
    const { adjusted, difference_m, difference_sigma_m } = one;
    return { ...point, adjusted, difference_m, difference_sigma_m, marks: point.marks.map((mark) => withTests(mark, one)) };
  });
}

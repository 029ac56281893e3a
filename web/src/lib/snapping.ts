// SPDX-License-Identifier: Apache-2.0
// Which vertex that is drawn a click means.
import type { Vector2 } from "./types";

/** The nearest one within reach, counted in the unit of places; nothing: none. */
export function nearestVertex<V>(
  features: readonly { id: string; vertices: readonly V[] }[],
  place: (vertex: V) => Vector2 | null | undefined,
  [x, y]: Vector2,
  reach: number,
): { feature: string; vertex: number } | undefined {
  let best: { feature: string; vertex: number } | undefined;
  let least = reach;
  for (const { id, vertices } of features)
    vertices.forEach((one, vertex) => {
      const at = place(one);
      const distance = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
      if (distance <= least) [best, least] = [{ feature: id, vertex }, distance];
    });
  return best;
}

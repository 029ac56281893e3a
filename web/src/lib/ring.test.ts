// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { isInside } from "./ring";
import type { Vector2 } from "./types";

const square: Vector2[] = [[0, 0], [10, 0], [10, 10], [0, 10]];

test("a position is in a ring or not, also in a concave one, closed or not", () => {
  const notch: Vector2[] = [[0, 0], [10, 0], [10, 10], [5, 2], [0, 10]];
  for (const closes of [false, true]) {
    const [plain, concave] = [square, notch].map((ring) => (closes ? [...ring, ring[0] as Vector2] : ring)) as [Vector2[], Vector2[]];
    expect(isInside(plain, 5, 5)).toBe(true);
    for (const [x, y] of [[-1, 5], [11, 5], [5, -1], [5, 11], [20, 20]] as Vector2[]) expect(isInside(plain, x, y)).toBe(false);
    expect([[1, 5], [9, 5], [5, 5], [5, 1], [-1, 5]].map(([x, y]) => isInside(concave, x as number, y as number))).toEqual([true, true, false, true, false]);
  }
  expect(isInside([], 1, 1)).toBe(false);
});

test("of neighbours one has what lies on their common side, and what the left and lower sides have belongs to the ring", () => {
  const right = square.map(([x, y]): Vector2 => [x + 10, y]);
  for (let y = 0.25; y < 10; y += 0.25) expect(isInside(square, 10, y)).not.toBe(isInside(right, 10, y));
  expect([isInside(square, 0, 5), isInside(square, 10, 5), isInside(square, 5, 0), isInside(square, 5, 10)]).toEqual([true, false, true, false]);
});

// SPDX-License-Identifier: Apache-2.0
import { expect, it } from "vitest";

import { squared } from "./drafting.svelte";
import { nearestVertex } from "./snapping";

it("puts a vertex square to the side before it", () => {
  expect(squared([0, 0, 5], [10, 0, 5], [12, 7, 5])).toEqual([10, 7]);
  const [x, y] = squared([0, 0, 0], [3, 4, 0], [1, 9, 0]);
  expect(3 * (x - 3) + 4 * (y - 4)).toBeCloseTo(0, 12);
  expect(squared([1, 1, 0], [1, 1, 0], [4, 5, 0])).toEqual([4, 5]);
});

it("finds the nearest vertex within reach", () => {
  const features = [
    { id: "F1", vertices: [{ at: [0, 0] }, { at: [10, 0] }] },
    { id: "F2", vertices: [{ at: [9, 1] }, { at: null }] },
  ];
  const place = (vertex: { at: number[] | null }): [number, number] | null => vertex.at as [number, number] | null;
  expect(nearestVertex(features, place, [9.4, 0.7], 3)).toEqual({ feature: "F2", vertex: 0 });
  expect(nearestVertex(features, place, [5, 5], 3)).toBeUndefined();
});

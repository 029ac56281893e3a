// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { boundsOf, isInside, levelFor, pixelOf, resolutionsOf, screenOf, tilesOf, viewOf } from "./pixels";
import type { ImageInfo, Vector2 } from "./types";

const image = { id: 1, width: 1000, height: 700, levels: 3 } as ImageInfo;

test("a pixel goes into the view and back, and the corner is the origin", () => {
  expect(viewOf([12.5, 30.25])).toEqual([12.5, -30.25]);
  expect(pixelOf(viewOf([12.5, 30.25]))).toEqual([12.5, 30.25]);
  expect(viewOf([0, 0])).toEqual([0, 0]);
});

test("the last level is the native size, each above it half of that", () => {
  expect(resolutionsOf(3)).toEqual([4, 2, 1]);
});

test("a level is chosen that shows no less than the screen can", () => {
  expect([0.1, 0.25, 0.26, 0.5, 0.51, 1, 16].map((scale) => levelFor(3, scale))).toEqual([0, 0, 1, 1, 2, 2, 2]);
  for (const scale of [0.13, 0.3, 0.77, 1]) {
    const z = levelFor(6, scale);
    expect(resolutionsOf(6)[z]).toBeLessThanOrEqual(1 / scale);
    expect(resolutionsOf(6)[z - 1]).toBeGreaterThan(1 / scale);
  }
});

test("tiles cover a window, and none lies beyond the photograph", () => {
  expect(tilesOf(image, 0, [-50, -50, 5000, 5000], 256)).toEqual([{ z: 0, x: 0, y: 0 }]);
  expect(tilesOf(image, 2, [250, 10, 520, 20], 256).map((one) => one.x)).toEqual([0, 1, 2]);
  expect(tilesOf(image, 2, [0, 0, 1000, 700], 256)).toHaveLength(12);
  expect(tilesOf(image, 2, [1001, 0, 1100, 100], 256)).toEqual([]);
  expect(tilesOf(image, 1, [512, 512, 513, 513], 256)).toEqual([{ z: 1, x: 1, y: 1 }]);
});

test("the middle of a window is its centre, and its corners are its bounds", () => {
  const window = { centre: [100.25, 50.5] as Vector2, scale: 8, width: 160, height: 80 };
  expect(screenOf(window, [100.25, 50.5])).toEqual([80, 40]);
  const [left, top, right, bottom] = boundsOf(window);
  expect(screenOf(window, [left, top])).toEqual([0, 0]);
  expect(screenOf(window, [right, bottom])).toEqual([160, 80]);
});

test("the rim belongs to the photograph", () => {
  expect([[0, 0], [1000, 700], [1000.1, 5], [5, -0.1]].map((pixel) => isInside(image, pixel as Vector2))).toEqual([true, true, false, false]);
});

// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import type { ImageInfo, Vector2 } from "../../lib/types";
import { ellipseOf, median, roundFactor, seenBy } from "./geometry";

const square: Vector2[] = [[0, 0], [10, 0], [10, 10], [0, 10]];

test("who sees a place, the nearest first, those without a footprint not at all", () => {
  const image = (id: number, e: number | null, footprint: Vector2[] | null): ImageInfo => ({
    id, file: `${id}.jpg`, width: 1, height: 1, levels: 1, camera: 1, oriented: true, sigma_m: null, marks: 0, footprint,
    position: e === null ? null : [e, 5, 100],
  });
  const images = [image(1, 9, square), image(2, 6, square), image(3, 5, null), image(4, null, square), image(5, 5, [[20, 0], [30, 0], [30, 9]])];
  expect(seenBy(images, [5, 5]).map((one) => [one.image.id, one.distance_m])).toEqual([[2, 1], [1, 4], [4, null]]);
});

test("factors are round and not above", () => {
  expect([1, 1.9, 2, 4.99, 5, 9.9, 10, 0.5, 0.049, 1234].map(roundFactor)).toEqual([1, 1, 2, 2, 5, 5, 10, 0.5, 0.02, 1000]);
  for (const none of [0, -1, NaN, Infinity]) expect(roundFactor(none)).toBe(1);
});

// C = R diag(4, 1) R' with the major axis 30 degrees from east: the axes must come back. Rounding: 1e-12.
test("the ellipse of a covariance has its axes", () => {
  const angle = Math.PI / 6;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const axes = ellipseOf(Math.sqrt(4 * c * c + s * s), Math.sqrt(4 * s * s + c * c), 3 * c * s);
  expect(axes.major).toBeCloseTo(2, 12);
  expect(axes.minor).toBeCloseTo(1, 12);
  expect(axes.angle).toBeCloseTo(angle, 12);
  expect(ellipseOf(1, 3, 0).angle).toBeCloseTo(Math.PI / 2, 12);
});

test("the middle one", () => {
  expect(median([3, NaN, 1, 2])).toBe(2);
  expect(median([])).toBeUndefined();
});

// SPDX-License-Identifier: Apache-2.0
import { expect, it } from "vitest";

import type { Control, Mark } from "../../lib/types";
import { asNow } from "./merge";

const mark = (image: number, x: number, w: number | null): Mark => ({ image, file: `${image}.jpg`, pixel: [x, 5], sigma_px: 0.5, residual_px: w === null ? null : [1, 1], w, redundancy: 0.5, detectable_px: 2 });
const control = (name: string, difference: number | null, ...marks: Mark[]): Control => ({
  sigma0: 1,
  points: [{ name, role: "control", position: [1, 2, 3], sigma_m: [0.1, 0.1, 0.1], adjusted: null, difference_m: difference === null ? null : [difference, 0, 0], difference_sigma_m: null, marks }],
});

it("shows what the block says now, and nothing of marks that it has elsewhere", () => {
  const merged = asNow(control("A", 1, mark(1, 10, 3), mark(2, 20, 4), mark(3, 30, 5)), control("A", 2, mark(1, 10, 7), mark(2, 21, 8)));
  expect(merged[0]?.difference_m).toEqual([2, 0, 0]);
  expect(merged[0]?.marks.map((one) => one.w)).toEqual([7, null, null]);
  expect(merged[0]?.marks.map((one) => one.pixel[0])).toEqual([10, 20, 30]);
});

it("leaves points alone that the block has not", () => {
  const before = control("B", 1, mark(1, 10, 3));
  expect(asNow(before, control("A", 2))).toEqual(before.points);
  expect(asNow(before, undefined)).toEqual(before.points);
  expect(asNow(undefined, undefined)).toEqual([]);
});

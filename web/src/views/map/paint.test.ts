// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { paintedColours, paintedValues, ramp } from "./paint";

test("colours with opacity, colours, grey", () => {
  expect([...paintedColours([[1], [2], [3], [0]], null)]).toEqual([1, 2, 3, 0]);
  expect([...paintedColours([[1], [2], [3]], 0)]).toEqual([1, 2, 3, 255]);
  expect([...paintedColours([[7, 0]], 0)]).toEqual([7, 7, 7, 255, 0, 0, 0, 0]);
  expect([...paintedColours([[7], [9]], null)]).toEqual([7, 7, 7, 9]);
  expect(paintedColours([], null)).toHaveLength(0);
});

test("the ramp goes from end to end and no further", () => {
  expect(ramp(0)).toEqual([0x44, 0x01, 0x54]);
  expect(ramp(1)).toEqual([0xfd, 0xe7, 0x25]);
  expect(ramp(-3)).toEqual(ramp(0));
  expect(ramp(3)).toEqual(ramp(1));
});

test("what is not known is clear", () => {
  const painted = paintedValues([-9999, NaN, 0, 2], -9999, 0, 2);
  expect([3, 7, 11, 15].map((at) => painted[at])).toEqual([0, 0, 255, 255]);
  expect([...painted.slice(12, 15)]).toEqual(ramp(1));
});

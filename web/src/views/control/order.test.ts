// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import type { ControlPoint, MarkedPoint, Place } from "../../lib/types";
import { chipScale, isDoubted, nextPlace, nextPoint, placesInOrder, sorted, testsOf, worstDifference, worstW } from "./order";

const point = (name: string, role: "control" | "check", difference: number | null, ...w: (number | null)[]): ControlPoint =>
  ({ name, role, difference_m: difference === null ? null : [0.001, 0, difference], difference_sigma_m: [0.01, 0.01, 0.02], marks: w.map((one, image) => ({ image, w: one })) }) as ControlPoint;
const points = [point("P10", "check", 0.01, 1, -4), point("P2", "control", -0.1), point("P1", "control", null, 2)];
const place = (image: number, marked: boolean, file = `${image}.jpg`): Place => ({ image, file, marked, pixel: [0, 0], ellipse: null, hidden: false, sigma_after_m: null });

test("the worst difference is that of most standard deviations, not of most metres", () => {
  expect(worstDifference([0.03, -0.05, 0.06], [0.005, 0.02, 0.05])).toEqual({ axis: "E", metres: 0.03, sigma_m: 0.005 });
  expect(worstDifference([null, null, null], null)).toBeUndefined();
  expect(isDoubted(worstDifference([0.03], [0.0101]))).toBe(false);
  expect(isDoubted(worstDifference([-0.031], [0.01]))).toBe(true);
});

test("points are sorted by what a person wants to see first, and by name where that is alike", () => {
  const names = (column: Parameters<typeof sorted>[1], isReversed = false): string => sorted(points, column, isReversed).map((one) => one.name).join(" ");
  expect(names("name")).toBe("P1 P2 P10");
  expect(names("name", true)).toBe("P10 P2 P1");
  expect(names("role")).toBe("P1 P2 P10");
  expect(names("marks")).toBe("P2 P1 P10");
  expect(names("difference")).toBe("P2 P10 P1");
  expect(names("w")).toBe("P10 P1 P2");
  expect(worstW(points[0] as ControlPoint)).toBe(-4);
});

test("marked places come last, or first by choice, and else stay in the order of the server", () => {
  const places = [place(3, false), place(1, false), place(2, true), place(0, true, "10.jpg")];
  const images = (order: Parameters<typeof placesInOrder>[1]): number[] => placesInOrder(places, order).map((one) => one.image);
  expect(images("best")).toEqual([3, 1, 2, 0]);
  expect(images("marked")).toEqual([2, 0, 3, 1]);
  expect(images("name")).toEqual([1, 2, 3, 0]);
});

test("the next place is the best that is open, not the one that is looked at", () => {
  const places = [place(3, false), place(1, false), place(2, true)];
  expect(nextPlace(places, undefined)?.image).toBe(3);
  expect(nextPlace(places, 3)?.image).toBe(1);
  expect(nextPlace([place(3, false), place(2, true)], 3)).toBeUndefined();
  expect(nextPlace([...places, place(5, false)], 1, new Set([3, 1]))?.image).toBe(5); // not to and fro between the best two
  expect(nextPlace(places, 1, new Set([3, 1]))?.image).toBe(3);
});

test("behind the last point comes the first", () => {
  expect(nextPoint(points, "P1")?.name).toBe("P10");
  expect(nextPoint(points, "P10", -1)?.name).toBe("P1");
  expect(nextPoint(points, "unknown")?.name).toBe("P10");
  expect(nextPoint([], "P1")).toBeUndefined();
});

test("a wide ellipse makes a small window show more", () => {
  expect(chipScale({ ...place(1, false), ellipse: { major_px: 2, minor_px: 1, angle_deg: 0 } }, 160)).toBe(2);
  expect(chipScale({ ...place(1, false), ellipse: { major_px: 100, minor_px: 50, angle_deg: 0 } }, 150)).toBe(0.25);
});

test("tests are those of the marks as they are now, else those of the adjustment", () => {
  const marked = { marks: [{ image: 0, residual_px: [0.1, -0.2], redundancy: [0.7, 0.4], w: [1, -2.5], detectable_px: [2, 3] }] } as unknown as MarkedPoint;
  expect(testsOf(points[0] as ControlPoint, 0, marked)).toEqual({ residual_px: [0.1, -0.2], w: -2.5, redundancy: 0.4, detectable_px: 3 });
  expect(testsOf(points[0] as ControlPoint, 1, marked).w).toBe(-4);
});

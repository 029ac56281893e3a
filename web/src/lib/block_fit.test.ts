// SPDX-License-Identifier: Apache-2.0
import proj4 from "proj4";
import { expect, test } from "vitest";

import { distanceTo, fitOf, projOf } from "./block_fit";
import type { Vector2 } from "./types";

const bounds = [500_000, 5_300_000, 500_300, 5_300_400] as const;

test("the distance from a rectangle is 0 within it, and that to its rim or corner outside", () => {
  expect(distanceTo(bounds, [500_100, 5_300_100])).toBe(0);
  expect(distanceTo(bounds, [500_100, 5_300_410])).toBe(10);
  expect(distanceTo(bounds, [500_303, 5_300_404])).toBe(5);
});

test("points in the block and around it are near", () => {
  const fit = fitOf([[500_100, 5_300_100], [500_500, 5_300_100], [501_000, 5_300_100]], bounds);
  expect(fit).toEqual({ isNear: [true, true, false], near: 2, least_m: 700, isSwapped: false, isDegrees: false });
});

test("exchanged axes, degrees and another zone are seen", () => {
  const points: Vector2[] = [[500_100, 5_300_100], [500_200, 5_300_300]];
  expect(fitOf(points.map(([e, n]) => [n, e]), bounds)).toMatchObject({ near: 0, isSwapped: true, isDegrees: false });
  expect(fitOf([[15.001, 47.8]], bounds)).toMatchObject({ near: 0, isDegrees: true });
  const zone32 = points.map((point) => proj4(projOf("EPSG:32633") ?? "", projOf("EPSG:32632") ?? "", point) as Vector2);
  const fit = fitOf(zone32, bounds);
  expect(fit).toMatchObject({ near: 0, isSwapped: false, isDegrees: false });
  expect(fit.least_m).toBeGreaterThan(400_000); // six degrees at 47.8 degrees of latitude are 449 km
  expect(fit.least_m).toBeLessThan(460_000);
});

test("a CRS is known by code and by words", () => {
  expect(projOf("EPSG:32654")).toBe(projOf("WGS84 UTM 54N"));
  expect(projOf("WGS84 UTM 7S")).toContain("+south");
  expect(projOf("+proj=utm +zone=17 +datum=WGS84")).toContain("zone=17");
  expect(projOf("epsg:25832")).toContain("+ellps=GRS80");
  expect([projOf("EPSG:31256"), projOf("WGS84 UTM 99N"), projOf("EPSG:32600"), projOf("local")]).toEqual([undefined, undefined, undefined, undefined]);
});

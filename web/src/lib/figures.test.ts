// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { decimalsOf, parted, rowsOf } from "./figures";

test("units are taken from names", () => {
  expect(parted("mean_reprojection_px")).toEqual({ name: "mean_reprojection", unit: "px" });
  expect(parted("tie_points")).toEqual({ name: "tie_points", unit: "" });
  expect(parted("m")).toEqual({ name: "m", unit: "" });
});

test("figures become rows; findings, empty lists and lists of objects do not", () => {
  const figures = { images: 6, check_rmse_m: [0.1, 0.2, 0.3], findings: [{}], not_oriented: [], pairs_by: { general: 15, film: [{ a: 1 }] }, crs: null };
  expect(rowsOf(figures)).toEqual([
    { name: "images", unit: "", values: [6] },
    { name: "check rmse", unit: "m", values: [0.1, 0.2, 0.3] },
    { name: "pairs by: general", unit: "", values: [15] },
    { name: "crs", unit: "", values: [null] },
  ]);
});

test("small numbers keep four digits", () => {
  expect([35165, 0.118, 0.00123, 12.345, 123.456, 1e-12].map(decimalsOf)).toEqual([0, 4, 6, 2, 1, 6]);
});

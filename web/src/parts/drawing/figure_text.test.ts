// SPDX-License-Identifier: Apache-2.0
import { expect, it } from "vitest";

import { figureText, kindsOf } from "./figure_text";

it("shows two digits of the standard deviation, and as many of the value", () => {
  expect(figureText({ kind: "distance", value: 12.34567, sigma: 0.0123, unit: "m" }, "en")).toBe("12.346 ± 0.012 m");
  expect(figureText({ kind: "area", value: 250.123, sigma: 1.9, unit: "m2" }, "de")).toBe("250,1 ± 1,9 m²");
  expect(figureText({ kind: "angle", value: Math.PI / 2, sigma: Math.PI / 1800, unit: "rad" }, "en")).toBe("90.00 ± 0.10 °");
  expect(figureText({ kind: "distance", value: 1, sigma: null, unit: "m" }, "en")).toBe("1.000 ± – m");
});

it("offers what so many vertices have", () => {
  expect(kindsOf(1, true)).toEqual([]);
  expect(kindsOf(2, true)).toContain("slope");
  expect(kindsOf(3, false)).toEqual(["angle", "length"]);
  expect(kindsOf(4, true)).toEqual(["length", "area", "plan_area"]);
});

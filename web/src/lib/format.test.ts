// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { bytes, count, duration, fixed, length } from "./format";

test("numbers follow the language, minus is a minus, what is not known a dash", () => {
  expect(fixed(-1234.5, 2, "en")).toBe("−1234.50");
  expect(fixed(-1234.5, 2, "de")).toBe("−1234,50");
  expect(count(1234567, "en")).toBe("1,234,567");
  expect(fixed(null, 2, "en")).toBe("–");
  expect(fixed(NaN, 2, "en")).toBe("–");
});

test("sizes, times and lengths have units", () => {
  expect([0, 12, 5400, 999_999, 1.5e6, 2.34e9].map((one) => bytes(one, "en"))).toEqual(["0.1 kB", "0.1 kB", "5.4 kB", "1000 kB", "1.5 MB", "2.34 GB"]);
  expect([0.07, 9.94, 42, 600, 7200].map((one) => duration(one, "en"))).toEqual(["0.1 s", "9.9 s", "42 s", "10 min", "2.0 h"]);
  expect([0.0123, 0.5, 12.345, 250, -0.2].map((one) => length(one, "en"))).toEqual(["0.0123 m", "0.500 m", "12.35 m", "250.0 m", "−0.200 m"]);
});

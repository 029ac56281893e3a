// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { equalised, histogramOf, isPlain, plainTone, toneTable } from "./tone";

test("a plain tone shows everything as it is", () => {
  expect(isPlain(plainTone)).toBe(true);
  expect(toneTable(plainTone, undefined, 5)).toEqual([0, 0.25, 0.5, 0.75, 1]);
});

test("tables rise and stay in range whatever is asked", () => {
  for (const brightness of [-1, 0, 0.7])
    for (const contrast of [-3, 0, 3])
      for (const gamma of [0.2, 1, 5]) {
        const table = toneTable({ brightness, contrast, gamma, equalise: false }, undefined);
        for (let i = 1; i < table.length; ++i) expect(table[i]).toBeGreaterThanOrEqual(table[i - 1] ?? 0);
        expect(Math.min(...table)).toBeGreaterThanOrEqual(0);
        expect(Math.max(...table)).toBeLessThanOrEqual(1);
      }
});

test("gamma lightens the dark, contrast leaves the middle", () => {
  expect(toneTable({ ...plainTone, gamma: 2 }, undefined, 5)[1]).toBeCloseTo(0.5);
  expect(toneTable({ ...plainTone, contrast: 1 }, undefined, 5)).toEqual([0, 0, 0.5, 1, 1]);
});

test("equalising a picture of few dark values spreads them over the range", () => {
  const bytes: number[] = [];
  for (let i = 0; i < 100; ++i) bytes.push(10 + (i % 4), 10 + (i % 4), 10 + (i % 4), 255);
  const counts = histogramOf(bytes);
  expect(counts.slice(10, 14)).toEqual([25, 25, 25, 25]);
  expect(equalised(counts).slice(9, 15)).toEqual([0, 0.125, 0.375, 0.625, 0.875, 1]);
});

// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";

import { pushIn, shaped } from "./devices";

const report = (...counts: number[]): DataView => {
  const data = new DataView(new ArrayBuffer(2 * counts.length));
  counts.forEach((count, k) => data.setInt16(2 * k, count, true));
  return data;
};

describe("devices", () => {
  it("reads the counts of a six-axis mouse", () => {
    expect(pushIn(report(350, -350, 350))).toEqual({ x: 1, y: -1, up: -1 });
    expect(pushIn(report(700, 0, 0))?.x).toBe(1);
    expect(pushIn(report(1))).toBeUndefined();
  });
  it("leaves a hand at rest alone and is finer near the middle", () => {
    expect(shaped(0.05)).toBe(0);
    expect(shaped(-0.05)).toBe(0);
    expect(shaped(0.54)).toBeCloseTo(0.25, 9);
    expect(shaped(-1)).toBe(-1);
  });
});

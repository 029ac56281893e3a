// SPDX-License-Identifier: Apache-2.0
import { afterEach, describe, expect, it, vi } from "vitest";

import { Devices, pushIn, shaped } from "./devices";

const report = (...counts: number[]): DataView => {
  const data = new DataView(new ArrayBuffer(2 * counts.length));
  counts.forEach((count, k) => data.setInt16(2 * k, count, true));
  return data;
};

afterEach(() => {
  vi.unstubAllGlobals();
});

describe("devices", () => {
  it("tells a button once, however many game pads there are and long it is held", () => {
    const pad = (...pressed: boolean[]): object => ({ connected: true, axes: [0, 0, 0, 0], buttons: pressed.map((one) => ({ pressed: one })) });
    let pads: (object | null)[] = [];
    vi.stubGlobal("navigator", { getGamepads: () => pads });
    const told: number[] = [];
    const devices = new Devices((button) => told.push(button));
    pads = [pad(true, false), null, pad(false, false)];
    for (let frame = 0; frame < 3; ++frame) devices.push();
    expect(told).toEqual([0]);
    pads = [pad(true, false), null, pad(false, true)];
    for (let frame = 0; frame < 3; ++frame) devices.push();
    expect(told).toEqual([0, 1]);
    pads = [pad(false, false), null, pad(false, false)];
    devices.push();
    pads = [pad(false, false), null, pad(true, false)];
    devices.push();
    expect(told).toEqual([0, 1, 0]);
    devices.dispose();
  });
  it("is asked only where there is a device", () => {
    let pads: (object | null)[] = [null];
    vi.stubGlobal("navigator", { getGamepads: () => pads });
    const devices = new Devices(() => {});
    expect(devices.isThere).toBe(false);
    pads = [null, { connected: true, axes: [], buttons: [] }];
    expect(devices.isThere).toBe(true);
    devices.dispose();
  });
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

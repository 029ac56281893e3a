// SPDX-License-Identifier: Apache-2.0
import { beforeEach, expect, test, vi } from "vitest";

import type { CloudHeader } from "./cloud_file";
import type { FromWorker, PickRay, ToWorker } from "./messages";
import type { CloudPoints, PointsEvents } from "./points";

class FakeWorker {
  static last: FakeWorker;
  said: ToWorker[] = [];
  onmessage: (event: { data: FromWorker }) => void = () => {};
  onerror: (event: { message: string }) => void = () => {};
  constructor() {
    FakeWorker.last = this;
  }
  postMessage(message: ToWorker): void {
    this.said.push(message);
  }
  answer(data: FromWorker): void {
    this.onmessage({ data });
  }
  terminate(): void {}
}

vi.stubGlobal("Worker", FakeWorker);
const events = { opened: vi.fn(), failed: vi.fn(), changed: vi.fn(), came: vi.fn(), spread: vi.fn(), classes: vi.fn() } satisfies PointsEvents;
const header = { centre: [0, 0, 0], half: 8 } as unknown as CloudHeader;
const ray: PickRay = { origin: [0, 0, 9], direction: [0, 0, -1], radius_m: 1, slope: 0 };

let points: CloudPoints;
beforeEach(async () => {
  vi.clearAllMocks();
  points = new (await import("./points")).CloudPoints(events);
});

test("a cloud is busy until it is opened, or cannot be", () => {
  expect(points.isBusy).toBe(false);
  points.open("a", []);
  expect(points.isBusy).toBe(true);
  points.open("b", []);
  FakeWorker.last.answer({ opened: header, nodes: [], address: "a" }); // of the one before
  expect([points.isBusy, points.header]).toEqual([true, undefined]);
  FakeWorker.last.answer({ opened: header, nodes: [], address: "b" });
  expect([points.isBusy, points.header]).toEqual([false, header]);
  points.open("c", []);
  events.changed.mockClear();
  FakeWorker.last.answer({ failed: "404", address: "c" });
  expect(points.isBusy).toBe(false);
  expect(events.failed).toHaveBeenLastCalledWith("404");
  expect(events.changed).toHaveBeenCalled(); // somebody looks whether all is at rest
});

test("regions are waited for until they are applied, or the worker has an error", async () => {
  points.setRegions([]);
  points.setRegions([]);
  FakeWorker.last.answer({ applied: true });
  expect(points.isBusy).toBe(true);
  const picked = points.pick(ray);
  events.changed.mockClear();
  FakeWorker.last.onerror({ message: "out of memory" });
  expect(points.isBusy).toBe(false);
  expect(await picked).toBeNull();
  expect(events.failed).toHaveBeenLastCalledWith("out of memory");
  expect(events.changed).toHaveBeenCalled();
  FakeWorker.last.answer({ applied: true }); // late
  points.setRegions([]);
  expect(points.isBusy).toBe(true);
  FakeWorker.last.answer({ applied: true });
  expect(points.isBusy).toBe(false);
});

// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { Failures } from "./failures";

test("what failed is asked for again later and later, a few times, and not at all once it came", () => {
  const failures = new Failures<string>();
  let now = 100;
  const waits = [];
  for (let wait = failures.failed("a", now); wait !== undefined; wait = failures.failed("a", now)) {
    waits.push(wait);
    expect([failures.isOff("a", now), failures.isOff("a", now + wait - 1), failures.isOff("a", now + wait)]).toEqual([true, true, false]);
    now += wait;
  }
  expect(waits).toEqual([1000, 2000, 4000, 8000, 16000]);
  expect([failures.isOff("a", now + 1e9), failures.isOff("b", now), failures.size]).toEqual([true, false, 1]);
  failures.succeeded("a");
  expect([failures.isOff("a", now), failures.size]).toEqual([false, 0]);
});

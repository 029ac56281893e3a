// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { stepInWork } from "./progress";
import type { Job } from "./types";

const steps = ["import", "detect", "match", "densify"];
const job = (stage: string, state: Job["state"] = "running"): Job => ({ id: 2, project: "p", name: "p", step: "densify", state, stage, done: 0, elapsed_s: 0, left_s: null });

test("the stage names the step", () => {
  expect(stepInWork(job("densify: overviews"), [], steps)).toBe("densify");
  expect(stepInWork(job("detect", "done"), [], steps)).toBeUndefined();
  expect(stepInWork(undefined, [], steps)).toBeUndefined();
});

test("else it follows the last one of the log", () => {
  const log = [{ job: 2, line: "import   up to date" }, { job: 2, line: "detect   5 features" }, { job: 1, line: "match    7 pairs" }, { job: 2, line: "note: something" }];
  expect(stepInWork(job("pairs"), log, steps)).toBe("match");
  expect(stepInWork(job("pairs"), [...log, { job: 2, line: "match: 4 of 15 pairs kept" }], steps)).toBe("match");
  expect(stepInWork(job("pairs"), log.slice(2), steps)).toBeUndefined();
});

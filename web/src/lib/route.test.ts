// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { hashOf, parsedHash } from "./route.svelte";

test("a place goes into the address and back", () => {
  expect(hashOf("a1", "photographs", "3")).toBe("#/a1/photographs/3");
  expect(parsedHash("#/a1/photographs/3")).toEqual({ project: "a1", view: "photographs", rest: ["3"] });
  const rest = ["page", "report/report.html", "50 % ü"];
  expect(parsedHash(hashOf("a1", "project", ...rest))).toEqual({ project: "a1", view: "project", rest });
});

test("what is no place is the project", () => {
  for (const hash of ["", "#", "#/", "#/%zz/nothing"]) expect(parsedHash(hash).view).toBe("project");
  expect(parsedHash("#a1").project).toBe("a1");
  expect(parsedHash("#/%zz").project).toBe("%zz");
});

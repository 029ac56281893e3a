// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { pointCommand } from "./point_command";

test("a point becomes a command, and what is not given a hyphen", () => {
  expect(pointCommand(" P 1 ", "check", ["1.5", "", "-2e1"], ["", "", ""])).toEqual({ words: ["point", "P 1", "check", "1.5", "-", "-2e1"] });
  expect(pointCommand("P1", "control", ["1", "2", ""], ["0.01", "0.02", ""])).toEqual({ words: ["point", "P1", "control", "1", "2", "-", "0.01", "0.02", "-"] });
});

test("what is no number is not sent", () => {
  const error = (...args: [string, string[], string[]]): unknown => (pointCommand(args[0], "control", args[1], args[2]) as { error?: string }).error;
  expect(error(" ", ["", "", ""], ["", "", ""])).toBe("no_name");
  expect(error("-", ["", "", ""], ["", "", ""])).toBe("bad_name");
  for (const text of ["1,5", "abc", "0x10", "1 2", "Infinity", "."]) expect(error("P", [text, "", ""], ["", "", ""])).toBe("bad_number");
  for (const text of ["0", "-1", "x"]) expect(error("P", ["1", "", ""], [text, "", ""])).toBe("bad_sigma");
  expect(error("P", ["", "1", ""], ["0.1", "0.1", ""])).toBe("lonely_sigma");
  expect(error("P", ["1", "1", ""], ["0.1", "", ""])).toBe("missing_sigma");
});

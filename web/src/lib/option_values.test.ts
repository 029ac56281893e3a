// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { choicesOf, edited, parsed, textOf } from "./option_values";
import type { Option, OptionGroup } from "./types";

const option = (more: Partial<Option>): Option => ({ name: "x", unit: "", help: "", kind: "number", default: 1, ...more });

test("numbers are parsed, bounded, and never read with a comma", () => {
  const bounded = option({ min: 0, max: 10 });
  for (const [text, value] of [["1", 1], [" 2.5 ", 2.5], ["1e-3", 0.001], [".5", 0.5], ["+3", 3], ["10", 10]] as const)
    expect(parsed(bounded, text)).toEqual({ value });
  expect(parsed(bounded, "-0.1")).toEqual({ wrong: { key: "options.too_small", bound: 0 } });
  expect(parsed(bounded, "10.01")).toEqual({ wrong: { key: "options.too_large", bound: 10 } });
  for (const text of ["2,5", "1.2.3", "0x10", "Infinity", "NaN", "ten", "1 2", "e3"])
    expect(parsed(bounded, text), text).toEqual({ wrong: { key: "options.no_number" } });
  expect(parsed(option({ kind: "whole" }), "2.5")).toEqual({ wrong: { key: "options.no_whole" } });
  expect(parsed(option({ kind: "whole" }), "2e1")).toEqual({ value: 20 });
});

test("nothing is null where the data decide, a text where that is one, and missing where a number must stand", () => {
  expect(parsed(option({ default: null }), "")).toEqual({ value: null });
  expect(parsed(option({ kind: "text", default: "" }), "")).toEqual({ value: "" });
  expect(parsed(option({ kind: "path", default: null }), " ")).toEqual({ value: null });
  expect(parsed(option({ default: 2 }), "")).toEqual({ wrong: { key: "options.missing" } });
});

test("flags have three states only where nothing is the default", () => {
  expect(choicesOf(option({ kind: "flag", default: null, automatic: "as it fits" })).map((one) => one.word)).toEqual(["", "true", "false"]);
  expect(choicesOf(option({ kind: "flag", default: true })).map((one) => one.word)).toEqual(["true", "false"]);
  expect(parsed(option({ kind: "flag", default: null }), "")).toEqual({ value: null });
  expect(parsed(option({ kind: "flag", default: null }), "false")).toEqual({ value: false });
});

const groups: OptionGroup[] = [
  { step: "match", group: "match", options: [option({ name: "max_ratio", default: 0.8, max: 1 }), option({ name: "word", kind: "word", default: "auto" })] },
];
const settings = { options: { match: { max_ratio: 0.8, word: "auto" } } };

test("only what differs from the settings is sent", () => {
  const typed = new Map([["match/max_ratio", "0.80"], ["match/word", "none"], ["other/x", "1"]]);
  expect(edited(groups, settings, typed)).toEqual({ changes: { match: { word: "none" } }, count: 1, wrong: new Map() });
  expect(edited(groups, settings, new Map()).count).toBe(0);
  const wrong = edited(groups, settings, new Map([["match/max_ratio", "2"]]));
  expect([...wrong.wrong]).toEqual([["match/max_ratio", { key: "options.too_large", bound: 1 }]]);
  expect(wrong.changes).toEqual({});
});

test("values are shown as project.json has them", () => {
  expect([null, undefined, true, 0, "auto"].map(textOf)).toEqual(["", "", "true", "0", "auto"]);
});

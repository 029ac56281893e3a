// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { filled } from "../lib/words.svelte";
import { de } from "./de";
import { en } from "./en";

const placesIn = (text: string): string[] => (text.match(/\{\w+\}/g) ?? []).sort();

test("both languages have the same keys", () => {
  expect(Object.keys(de)).toEqual(Object.keys(en));
});

test("no text is empty, and both languages fill in the same", () => {
  for (const [key, text] of Object.entries(en)) {
    const other = (de as Record<string, string>)[key] ?? "";
    expect(text.trim() && other.trim(), key).not.toBe("");
    expect(placesIn(other), key).toEqual(placesIn(text));
  }
});

test("what is not given stays as it is", () => {
  expect(filled("{a} of {b}", { a: 3 })).toBe("3 of {b}");
});

// SPDX-License-Identifier: Apache-2.0
import { readFileSync } from "node:fs";
import { expect, test } from "vitest";

import type { Finding } from "../lib/types";
import { remedyOf, whatOf } from "./findings";
import { findingsDe, remediesDe } from "./findings_de";

// The closed lists of the program: codes with their figures, words of figures and of remedies.
const source = readFileSync(new URL("../../../src/collinea/base/finding.cc", import.meta.url), "utf8").replace(/\n\s+/g, " ");
const words = (kind: string): Map<string, string> => new Map([...source.matchAll(new RegExp(`\\{${kind}::(k\\w+), "(\\w+)"`, "g"))].map((one) => [one[1] as string, one[2] as string]));
const figureNames = words("F");
const figuresOf = new Map(
  [...source.matchAll(/\{C::k\w+, "(\w+)", k\w+((?:, F::k\w+)*)\}/g)].map((one) => [one[1] as string, [...(one[2] as string).matchAll(/F::(k\w+)/g)].map((name) => figureNames.get(name[1] as string) as string)]),
);
const remedies = new Set(words("R").values());

const finding = (code: string, more: Partial<Finding> = {}): Finding => ({ code, severity: "weak", what: "In English.", ...more });
const subject = (name: string): { kind: string; name: string } => ({ kind: "image", name });

test("codes, figures and remedies are those of the program", () => {
  expect(figuresOf.size).toBeGreaterThan(150);
  for (const code of Object.keys(findingsDe)) expect([...figuresOf.keys()]).toContain(code);
  for (const code of Object.keys(remediesDe)) expect(remedies).toContain(code);
});

test("every sentence is whole with the figures that come with its code", () => {
  for (const [code, names] of figuresOf) {
    if (!Object.hasOwn(findingsDe, code)) continue;
    for (const count of [1, 3]) {
      const figures = names.map((name) => ({ name, value: name === "count" ? count : 0.12345, unit: "" }));
      const told = whatOf(finding(code, { figures, subjects: [subject("A.jpg"), subject("B.jpg")] }), "de");
      expect(told.isForeign, code).toBe(false);
      expect(told.text, code).not.toMatch(/[{}–]|undefined/);
    }
  }
});

test("what has no German sentence, or more in it than that, stays English and says so", () => {
  expect(whatOf(finding("systematic"), "de")).toEqual({ text: "In English.", isForeign: true });
  expect(whatOf(finding("image_duplicate", { subjects: [subject("A.jpg")] }), "de")).toEqual({ text: "In English.", isForeign: true });
  expect(whatOf(finding("loose_images", { subjects: [{ kind: "image", name: "A.jpg", aspect: "attitude" }] }), "de").isForeign).toBe(true);
  expect(whatOf(finding("loose_images", { subjects: [subject("A.jpg")] }), "en")).toEqual({ text: "In English.", isForeign: false });
});

test("products have their names", () => {
  expect(whatOf(finding("no_ground", { subjects: [{ kind: "product", name: "terrain_model" }] }), "de").text).toContain("kein Geländemodell");
});

test("figures have their decimals, and remedies are one sentence", () => {
  const figures = [{ name: "ratio", value: 3.26, unit: "1" }, { name: "sigma_px", value: 0.0867, unit: "px" }];
  const one = finding("control_measurement_sigma", { figures, remedy: "Look.", remedies: [{ code: "look_for_marks" }, { code: "set_option", option: { group: "import", field: "control_sigma_px", value: "1" } }] });
  expect(whatOf(one, "de").text).toBe("Bildmessungen der Passpunkte verfehlen sich um das 3,3-fache ihrer Standardabweichung. Sie wird zu 0,087 px angenommen.");
  expect(remedyOf(one, "de")?.text).toBe("Nach Markierungen suchen, die nicht in allen Bildern denselben Punkt zeigen, oder Option control_sigma_px = 1 setzen.");
  expect(remedyOf(finding("image_duplicate"), "de")).toBeUndefined();
});

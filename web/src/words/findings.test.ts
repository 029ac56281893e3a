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

test("a wrong point says whether its plan or its height is wrong", () => {
  const of = (plan: number, height: number): string => {
    const figures = [["offset_m", Math.hypot(plan, height)], ["offset_plan_m", plan], ["offset_height_m", height]].map(([name, value]) => ({ name: name as string, value: value as number, unit: "m" }));
    return whatOf(finding("control_point", { figures, subjects: [subject("P1")] }), "de").text.split(" von dem ab")[0] as string;
  };
  expect(of(0.1, -3)).toBe("Die Koordinaten von P1 weichen um 3,00 m in der Höhe");
  expect(of(3, 0.1)).toBe("Die Koordinaten von P1 weichen um 3,00 m in der Lage");
  expect(of(3, -4)).toBe("Die Koordinaten von P1 weichen um 5,00 m");
});

test("one is told as one, and of many the first is named", () => {
  const figures = (count: number): Finding["figures"] => [{ name: "count", value: count, unit: "1" }, { name: "of", value: 5, unit: "1" }];
  const told = (count: number): string => whatOf(finding("positions_of_others", { figures: figures(count), subjects: [subject("gnss.csv"), subject("z.jpg")] }), "de").text;
  expect(told(1)).toBe("1 von 5 Bildern in gnss.csv ist hier nicht dabei: z.jpg.");
  expect(told(3)).toBe("3 von 5 Bildern in gnss.csv sind hier nicht dabei, das erste: z.jpg.");
});

// A disagreement of image measurements is of two and more.
test("a sentence that begins with a count has a form for one", () => {
  for (const [code, entry] of Object.entries(findingsDe)) if (!Array.isArray(entry)) expect(entry, code).not.toMatch(/\{count\} (?!Bildern verfehlen)/);
});

test("shifts have their signs", () => {
  const figures = [["east_m", 0.5], ["north_m", -0.25], ["up_m", 0]].map(([name, value]) => ({ name: name as string, value: value as number, unit: "m" }));
  expect(whatOf(finding("positions_shifted", { figures }), "de").text).toContain("um +0,50 m nach Ost, −0,25 m nach Nord und +0,00 m nach oben");
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

// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import type { Option } from "../lib/types";
import { textsOf } from "./options";
import { choicesDe, optionsDe } from "./options_de";

const option = (name: string): Option => ({ name, unit: "", help: "in English", kind: "word", default: "auto" });

test("help is German on the German page where there is a text, and else says that it is not", () => {
  expect(textsOf("ortho", option("balance"), "de")).toMatchObject({ help: "Helligkeit und Farbe der Bilder angleichen", isForeign: false });
  expect(textsOf("ortho", option("balance"), "en")).toMatchObject({ help: "in English", isForeign: false });
  expect(textsOf("ortho", option("constructor"), "de")).toMatchObject({ help: "in English", isForeign: true });
  expect(textsOf("orient", option("mode"), "de").meaning("incremental", "image after image")).toBe("Bild nach Bild");
  expect(textsOf("orient", option("mode"), "de").meaning("new", "new one")).toBe("new one");
});

test("choices are those of options that have a text", () => {
  for (const key of Object.keys(choicesDe)) expect(Object.keys(optionsDe)).toContain(key);
});

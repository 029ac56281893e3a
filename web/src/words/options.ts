// SPDX-License-Identifier: Apache-2.0
// Help of options and what their choices mean, in the language of the page where there are texts for them.
import type { Option } from "../lib/types";
import type { Language } from "../lib/words.svelte";
import { choicesDe, optionsDe } from "./options_de";

export interface OptionTexts {
  help: string;
  /** English, on a page of another language. */
  isForeign: boolean;
  /** Of a word of its choices. */
  meaning(word: string, inEnglish: string): string;
}

export function textsOf(group: string, option: Option, language: Language): OptionTexts {
  const key = `${group}.${option.name}`;
  const german = language === "de" && Object.hasOwn(optionsDe, key) ? optionsDe[key] : undefined;
  if (german === undefined) return { help: option.help, isForeign: language !== "en", meaning: (_word, inEnglish) => inEnglish };
  return { help: german, isForeign: false, meaning: (word, inEnglish) => choicesDe[key]?.[word] ?? inEnglish };
}

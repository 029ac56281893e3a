// SPDX-License-Identifier: Apache-2.0
// The catalogue: every text of the page by its key. What the server says (summaries, help of options) is English; findings are in words/findings.ts.
import { de } from "../words/de";
import { en, type Key } from "../words/en";
import { keep, kept } from "./keep";

export const languages = ["en", "de"] as const;
export type Language = (typeof languages)[number];
export type { Key };

const catalogues: Record<Language, Record<Key, string>> = { en, de };

/** A text with its {places} filled in. */
export function filled(text: string, values: Record<string, string | number>): string {
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => (name in values ? String(values[name]) : whole));
}

function ofBrowser(): Language {
  const asked = typeof navigator === "undefined" ? [] : navigator.languages;
  for (const one of asked) {
    const found = languages.find((language) => one.toLowerCase().startsWith(language));
    if (found) return found;
  }
  return "en";
}

class Words {
  language = $state<Language>(kept("language", languages, ofBrowser()));

  constructor() {
    this.#apply();
  }

  choose(language: Language): void {
    this.language = language;
    keep("language", language);
    this.#apply();
  }

  #apply(): void {
    if (typeof document !== "undefined") document.documentElement.lang = this.language;
  }
}

export const words = new Words();

/** The text of a key in the language of the page. */
export const t = (key: Key, values: Record<string, string | number> = {}): string => filled(catalogues[words.language][key], values);

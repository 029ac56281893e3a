// SPDX-License-Identifier: Apache-2.0
// Findings and what to do about them, in the language of the page where there are sentences for them.
import { fixed } from "../lib/format";
import type { Finding } from "../lib/types";
import type { Language } from "../lib/words.svelte";
import { findingsDe, productsDe, remediesDe } from "./findings_de";

export interface Sentence {
  text: string;
  /** English, on a page of another language. */
  isForeign: boolean;
}

const mostNames = 6;

/** A number with so many significant digits. */
function significant(value: number, digits: number, language: Language): string {
  const decimals = value === 0 ? 0 : digits - 1 - Math.floor(Math.log10(Math.abs(value)));
  return fixed(value, Math.min(Math.max(decimals, 0), 9), language);
}

/** What stands for a place of a template; nothing where the finding has not got it. */
function filling(place: string, finding: Finding, language: Language): string | undefined {
  const names = (finding.subjects ?? []).map((one) => (one.aspect !== undefined ? undefined : one.kind === "product" ? productsDe[one.name ?? ""] : one.name));
  if (/^\d+$/.test(place)) return names[Number(place)];
  if (place === "all") {
    const more = names.length - mostNames;
    return names.length && names.every((one) => one) ? names.slice(0, mostNames).join(", ") + (more > 0 ? ` (+ ${more})` : "") : undefined;
  }
  const [, name, how, digits] = /^(\w+?)(?:([:~%])(\d))?$/.exec(place) ?? [];
  const value = finding.figures?.find((one) => one.name === name)?.value;
  if (typeof value !== "number") return undefined;
  if (how === "%") return `${significant(100 * value, Number(digits), language)} %`;
  return how === "~" ? significant(value, Number(digits), language) : fixed(value, Number(digits ?? 0), language);
}

/** The template filled in; nothing where a part of it is not known. */
export function inWords(template: string, finding: Finding, language: Language): string | undefined {
  let isWhole = true;
  const text = template.replace(/\{([^}]+)\}/g, (_, place: string) => {
    const one = filling(place, finding, language);
    isWhole &&= one !== undefined;
    return one ?? "";
  });
  return isWhole ? text : undefined;
}

const capital = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

export function whatOf(finding: Finding, language: Language): Sentence {
  const entry = language === "de" && Object.hasOwn(findingsDe, finding.code) ? findingsDe[finding.code] : undefined;
  const isOne = finding.figures?.find((one) => one.name === "count")?.value === 1;
  const template = Array.isArray(entry) ? entry[isOne ? 0 : 1] : entry;
  const text = template === undefined ? undefined : inWords(template, finding, language);
  return text === undefined ? { text: finding.what, isForeign: language !== "en" } : { text, isForeign: false };
}

/** What to do; nothing where the finding says nothing of it. */
export function remedyOf(finding: Finding, language: Language): Sentence | undefined {
  if (!finding.remedy) return undefined;
  const phrases = (finding.remedies ?? []).map((one) => {
    if (one.code !== "set_option") return remediesDe[one.code];
    const { field, value } = one.option ?? { field: "", value: "" };
    return value ? `Option ${field} = ${value} setzen` : `siehe Option ${field}`;
  });
  if (language !== "de" || !phrases.length || phrases.some((one) => one === undefined)) return { text: finding.remedy, isForeign: language !== "en" };
  const last = phrases.pop() ?? "";
  const joint = finding.code === "datum_defect" ? " und " : ", oder ";
  return { text: `${capital(phrases.length ? phrases.join(", ") + joint + last : last)}.`, isForeign: false };
}

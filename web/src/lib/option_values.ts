// SPDX-License-Identifier: Apache-2.0
// Options as texts of a form, and back. A form holds texts alone: what is edited differs from the text of the setting.
import type { Choice, Option, OptionGroup, OptionValue, OptionValues, Settings } from "./types";

export const textOf = (value: OptionValue | undefined): string => (value === null || value === undefined ? "" : String(value));

/** What a select offers; a first choice of nothing where nothing is the default. */
export function choicesOf(option: Option): Choice[] {
  const words =
    option.kind === "flag"
      ? [
          { word: "true", meaning: "" },
          { word: "false", meaning: "" },
        ]
      : (option.choices ?? []);
  const standard = textOf(option.default);
  return words.some((choice) => choice.word === standard) ? words : [{ word: standard, meaning: option.automatic ?? "" }, ...words];
}

/** Why a text is no value of an option: words of the catalogue and what they name. */
export interface Wrong {
  key: "options.no_number" | "options.no_whole" | "options.too_small" | "options.too_large" | "options.missing";
  bound?: number;
}

export type Parsed = { value: OptionValue } | { wrong: Wrong };

export function parsed(option: Option, typed: string): Parsed {
  const text = typed.trim();
  const numeric = option.kind === "number" || option.kind === "whole";
  if (text === "") {
    if (numeric && typeof option.default === "number") return { wrong: { key: "options.missing" } };
    return { value: typeof option.default === "string" && option.default !== "auto" ? "" : null };
  }
  if (text === "auto") return { value: text };
  if (option.kind === "flag") return { value: text === "true" };
  if (!numeric) return { value: text };
  const value = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text) ? Number(text) : NaN;
  if (!Number.isFinite(value)) return { wrong: { key: "options.no_number" } };
  if (option.kind === "whole" && !Number.isInteger(value)) return { wrong: { key: "options.no_whole" } };
  if (option.min !== undefined && value < option.min) return { wrong: { key: "options.too_small", bound: option.min } };
  if (option.max !== undefined && value > option.max) return { wrong: { key: "options.too_large", bound: option.max } };
  return { value };
}

/** Texts that were typed, by "group/option". */
export type Draft = ReadonlyMap<string, string>;
export const draftKey = (group: string, option: string): string => `${group}/${option}`;

export interface Edited {
  changes: Record<string, OptionValues>;
  count: number;
  /** Keys of the draft that are no values. */
  wrong: Map<string, Wrong>;
}

/** What of a draft differs from the settings, of the groups given. */
export function edited(groups: OptionGroup[], settings: Settings, draft: Draft): Edited {
  const result: Edited = { changes: {}, count: 0, wrong: new Map() };
  for (const { group, options } of groups)
    for (const option of options) {
      const key = draftKey(group, option.name);
      const text = draft.get(key);
      const setting = settings.options[group]?.[option.name];
      if (text === undefined || text === textOf(setting)) continue;
      const outcome = parsed(option, text);
      if ("wrong" in outcome) {
        result.wrong.set(key, outcome.wrong);
      } else if (outcome.value !== setting) {
        (result.changes[group] ??= {})[option.name] = outcome.value;
        ++result.count;
      }
    }
  return result;
}

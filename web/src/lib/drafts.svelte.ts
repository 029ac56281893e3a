// SPDX-License-Identifier: Apache-2.0
import { SvelteMap } from "svelte/reactivity";

import { textOf } from "./option_values";
import type { Settings } from "./types";

const drafts = new Map<string, SvelteMap<string, string>>();

/** What was typed into forms of a project, by "group/option": kept until it is what the project has, whatever is looked at meanwhile. */
export function draftOf(project: string): SvelteMap<string, string> {
  let draft = drafts.get(project);
  if (!draft) drafts.set(project, (draft = new SvelteMap()));
  return draft;
}

/** Forgets what the settings have by now. */
export function settle(draft: SvelteMap<string, string>, settings: Settings): void {
  for (const [key, text] of [...draft]) {
    const [group = "", option = ""] = key.split("/");
    if (textOf(settings.options[group]?.[option]) === text) draft.delete(key);
  }
}

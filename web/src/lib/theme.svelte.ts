// SPDX-License-Identifier: Apache-2.0
import { kept, keep } from "./keep";

export const themes = ["system", "light", "dark"] as const;
export type ThemeName = (typeof themes)[number];

/** Light or dark: as the system has it, unless chosen. */
class Theme {
  name = $state<ThemeName>(kept("theme", themes, "system"));

  constructor() {
    this.#apply();
  }

  choose(name: ThemeName): void {
    this.name = name;
    keep("theme", name);
    this.#apply();
  }

  #apply(): void {
    if (typeof document === "undefined") return;
    if (this.name === "system") delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = this.name;
  }
}

export const theme = new Theme();

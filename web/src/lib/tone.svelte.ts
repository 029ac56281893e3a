// SPDX-License-Identifier: Apache-2.0
import { plainTone, type Tone } from "./tone";

const name = "collinea.tone";

function kept(): Tone {
  try {
    const held = JSON.parse(sessionStorage.getItem(name) ?? "{}") as Partial<Tone>;
    const number = (value: unknown, low: number, high: number, otherwise: number): number =>
      typeof value === "number" && value >= low && value <= high ? value : otherwise;
    return {
      brightness: number(held.brightness, -1, 1, 0),
      contrast: number(held.contrast, -3, 3, 0),
      gamma: number(held.gamma, 0.2, 5, 1),
      equalise: held.equalise === true,
    };
  } catch {
    return { ...plainTone };
  }
}

/** How photographs are shown, in all views until the tab is closed. */
class ShownTone {
  value = $state.raw<Tone>(typeof sessionStorage === "undefined" ? { ...plainTone } : kept());

  set(change: Partial<Tone>): void {
    this.value = { ...this.value, ...change };
    try {
      sessionStorage.setItem(name, JSON.stringify(this.value));
    } catch {
      // A browser that keeps nothing.
    }
  }
}

export const shownTone = new ShownTone();

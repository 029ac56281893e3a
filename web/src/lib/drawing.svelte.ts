// SPDX-License-Identifier: Apache-2.0
// The features of the project that is looked at, shared by all views that show or draw them.
import * as api from "./api";
import type { Drawing, Feature } from "./drawing_types";

class SharedDrawing {
  /** Nothing: not asked for yet, or a server that has none. */
  value = $state.raw<Drawing | undefined>();
  /** The chosen feature. */
  chosen = $state<string | undefined>();
  project = $state("");
  #latest = 0;

  get features(): Feature[] {
    return this.value?.features ?? [];
  }
  get chosenFeature(): Feature | undefined {
    return this.features.find((one) => one.id === this.chosen);
  }

  /** Asks anew; with the pixels of a photograph where one is named. */
  async load(project: string, image?: number): Promise<void> {
    const mine = ++this.#latest;
    if (this.project !== project) [this.value, this.chosen, this.project] = [undefined, undefined, project];
    const value = await api.drawing(project, image).catch(() => undefined);
    if (mine !== this.#latest) return;
    this.value = value;
    if (!this.features.some((one) => one.id === this.chosen)) this.chosen = undefined;
  }

  colourOf(layer: string): string {
    return this.value?.layers.find((one) => one.name === layer)?.colour ?? "#c00000";
  }
}

export const drawing = new SharedDrawing();

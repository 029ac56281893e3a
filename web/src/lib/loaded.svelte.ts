// SPDX-License-Identifier: Apache-2.0
import { isMissing, messageOf } from "./api";

/** What a request answered, for a view: its value, or why there is none. An answer that a later request overtook is dropped. */
export class Loaded<T> {
  value = $state.raw<T | undefined>();
  error = $state("");
  missing = $state(false);
  busy = $state(false);
  #latest = 0;

  /** The last value stays until the new one is there, unless `fresh`. */
  async load(request: () => Promise<T>, fresh = false): Promise<void> {
    const mine = ++this.#latest;
    if (fresh) this.value = undefined;
    this.busy = true;
    try {
      const value = await request();
      if (mine !== this.#latest) return;
      [this.value, this.error, this.missing] = [value, "", false];
    } catch (error) {
      if (mine !== this.#latest) return;
      [this.value, this.error, this.missing] = [undefined, messageOf(error), isMissing(error)];
    } finally {
      if (mine === this.#latest) this.busy = false;
    }
  }
}

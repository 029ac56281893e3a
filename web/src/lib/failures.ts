// SPDX-License-Identifier: Apache-2.0
// What could not be fetched, and when it may be asked for again: after 1 s, 2 s, 4 s and so on; after some failures no more.

const first_ms = 1000;
const mostFailures = 6;

export class Failures<Key> {
  readonly #of = new Map<Key, { count: number; again_ms: number }>();

  /** How long to wait until it may be asked for again [ms]; nothing: it is given up. */
  failed(key: Key, now_ms: number): number | undefined {
    const count = (this.#of.get(key)?.count ?? 0) + 1;
    const wait_ms = count < mostFailures ? first_ms * 2 ** (count - 1) : Infinity;
    this.#of.set(key, { count, again_ms: now_ms + wait_ms });
    return Number.isFinite(wait_ms) ? wait_ms : undefined;
  }
  succeeded(key: Key): void {
    this.#of.delete(key);
  }
  isOff(key: Key, now_ms: number): boolean {
    return now_ms < (this.#of.get(key)?.again_ms ?? -Infinity);
  }

  get size(): number {
    return this.#of.size;
  }
  clear(): void {
    this.#of.clear();
  }
}

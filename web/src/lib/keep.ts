// SPDX-License-Identifier: Apache-2.0
// What a person chose for the page itself, kept by the browser; where it keeps nothing, until the page is closed.

export function kept<T extends string>(name: string, words: readonly T[], otherwise: T): T {
  try {
    const value = localStorage.getItem(`collinea.${name}`);
    return words.find((word) => word === value) ?? otherwise;
  } catch {
    return otherwise;
  }
}

export function keep(name: string, value: string): void {
  try {
    localStorage.setItem(`collinea.${name}`, value);
  } catch {
    // A browser that keeps nothing.
  }
}

// SPDX-License-Identifier: Apache-2.0
// How grey values are shown: one table for brightness, contrast, gamma and equalisation.

export interface Tone {
  /** Added, of the range of grey values; in [-1, 1]. */
  brightness: number;
  /** Doublings of the slope in the middle; in [-3, 3]. */
  contrast: number;
  /** Above 1: dark parts become lighter. */
  gamma: number;
  /** All grey values as often. */
  equalise: boolean;
}

export const plainTone: Readonly<Tone> = { brightness: 0, contrast: 0, gamma: 1, equalise: false };
export const isPlain = (tone: Tone): boolean => !tone.equalise && tone.brightness === 0 && tone.contrast === 0 && tone.gamma === 1;

/** How often each of 256 grey values is; of bytes r, g, b, a. */
export function histogramOf(bytes: ArrayLike<number>): number[] {
  const counts = new Array<number>(256).fill(0);
  for (let i = 0; i + 3 < bytes.length; i += 4) {
    const grey = Math.round(0.299 * (bytes[i] ?? 0) + 0.587 * (bytes[i + 1] ?? 0) + 0.114 * (bytes[i + 2] ?? 0));
    counts[grey] = (counts[grey] ?? 0) + 1;
  }
  return counts;
}

/** The part of grey values that are below each one, half of those that equal it counted with them; a straight line of nothing. */
export function equalised(counts: readonly number[]): number[] {
  const sum = counts.reduce((all, one) => all + one, 0);
  let below = 0;
  return counts.map((one, grey) => {
    const value = sum ? (below + one / 2) / sum : grey / (counts.length - 1);
    below += one;
    return value;
  });
}

/** What 0 ... 1 is shown as, at `size` equal steps. */
export function toneTable(tone: Tone, counts: readonly number[] | undefined, size = 65): number[] {
  const equal = tone.equalise && counts ? equalised(counts) : undefined;
  return Array.from({ length: size }, (_, at) => {
    let value = at / (size - 1);
    if (equal) value = equal[Math.round(value * (equal.length - 1))] ?? value;
    value = value ** (1 / tone.gamma);
    value = (value - 0.5) * 2 ** tone.contrast + 0.5 + tone.brightness;
    return Math.min(1, Math.max(0, value));
  });
}

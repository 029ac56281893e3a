// SPDX-License-Identifier: Apache-2.0
// Which photographs are listed.
import type { ImageInfo } from "../../lib/types";

export const filters = ["all", "oriented", "not_oriented", "marked", "not_marked"] as const;
export type Filter = (typeof filters)[number];

const passes: Record<Filter, (image: ImageInfo) => boolean> = {
  all: () => true,
  oriented: (image) => image.oriented,
  not_oriented: (image) => !image.oriented,
  marked: (image) => image.marks > 0,
  not_marked: (image) => image.marks === 0,
};

/** Those of a state whose name holds a text, in any letter case; by name, numbers in it by their value. */
export function listed(images: readonly ImageInfo[], text: string, filter: Filter): ImageInfo[] {
  const wanted = text.trim().toLowerCase();
  return images
    .filter((image) => passes[filter](image) && image.file.toLowerCase().includes(wanted))
    .sort((a, b) => a.file.localeCompare(b.file, "en", { numeric: true }) || a.id - b.id);
}

/** The one so many behind another, in a ring; the first where that is not listed. */
export function neighbour(images: readonly ImageInfo[], id: number | undefined, step: number): ImageInfo | undefined {
  const at = images.findIndex((image) => image.id === id);
  if (at < 0 || !images.length) return images[0];
  return images[(at + step + images.length) % images.length];
}

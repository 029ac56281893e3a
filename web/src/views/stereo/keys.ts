// SPDX-License-Identifier: Apache-2.0
// The keys of the stereoplotter, as the page lists them. Those of drawing are the bar's.
import type { Key } from "../../lib/words.svelte";

export const keyOf = (event: KeyboardEvent): string => (event.key.length === 1 ? event.key.toLowerCase() : event.key);

export const stereoKeys: [string, Key][] = [
  ["← → ↑ ↓", "stereo.key.plan"],
  ["PgUp PgDn", "stereo.key.height"],
  ["G", "stereo.key.ground"],
  ["K", "stereo.key.surface"],
  ["H", "stereo.key.contour"],
  ["Space", "stereo.key.vertex"],
  ["Enter C", "stereo.key.finish"],
  ["D", "stereo.key.display"],
  ["E", "stereo.key.swap"],
  ["F", "stereo.key.fixed"],
  ["M", "stereo.key.capture"],
  ["N B", "stereo.key.pair"],
  ["+ − 0 1 2 4 8", "stereo.key.zoom"],
];

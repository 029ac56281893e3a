// SPDX-License-Identifier: Apache-2.0
// Features that are drawn, and the figure in work, over the cloud.
import { drafting } from "../../lib/drafting.svelte";
import { drawing } from "../../lib/drawing.svelte";
import type { FeatureKind } from "../../lib/drawing_types";
import type { Overlay } from "./overlays";
import { sum, type Triple } from "./viewpoint";

const chosenColour = "#ffd400";
const draftColour = "#00a0ff";

function show(overlay: Overlay, places: Triple[], kind: FeatureKind, colour: string, hasMarks: boolean): void {
  if (places.length > 1) overlay.line(places, kind === "polygon" && places.length > 2, colour);
  if (hasMarks || places.length === 1) for (const place of places) overlay.mark(place, colour);
}

export function showFeatures(overlay: Overlay, origin: Triple): void {
  overlay.clear();
  for (const feature of drawing.features) {
    const isChosen = feature.id === drawing.chosen;
    const places = feature.vertices.map((one) => sum(one.position, origin, -1));
    show(overlay, places, feature.kind, isChosen ? chosenColour : drawing.colourOf(feature.layer), isChosen);
  }
}

export function showDraft(overlay: Overlay, origin: Triple): void {
  overlay.clear();
  const kind = drafting.tool === "measure" && drafting.vertices.length > 2 ? "polygon" : drafting.kind;
  show(overlay, drafting.vertices.map((one) => sum(one.position, origin, -1)), kind, draftColour, true);
}

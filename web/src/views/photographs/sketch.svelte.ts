// SPDX-License-Identifier: Apache-2.0
// What is drawn, in one photograph: where the server says that it shows each vertex, and what clicks there mean.
import * as api from "../../lib/api";
import { drafting } from "../../lib/drafting.svelte";
import { drawing } from "../../lib/drawing.svelte";
import type { Vertex } from "../../lib/drawing_types";
import { nearestVertex } from "../../lib/snapping";
import type { Vector2 } from "../../lib/types";
import type { ShownFigure, ShownMark } from "../../parts/photo/paint";

const reach = 10; // in which a click means a vertex [px of the screen]
const clickSigma = 0.5; // [px]

export class PhotoSketch {
  image = $state<number | undefined>();
  /** The vertex of the chosen feature that is moved by dragging. */
  #held = $state.raw<{ feature: string; vertex: number } | undefined>();
  #draft = $state.raw<(Vector2 | null)[]>([]);
  #latest = 0;

  chosenVertex = $derived(this.#held && this.#held.feature === drawing.chosen ? this.#held.vertex : undefined);

  figures = $derived<ShownFigure[]>([
    ...drawing.features.map((one) => ({
      kind: one.kind, points: one.vertices.map((vertex) => vertex.pixel ?? null), colour: drawing.colourOf(one.layer), chosen: one.id === drawing.chosen, open: false,
    })),
    ...(this.#draft.length ? [{ kind: drafting.tool === "measure" ? ("line" as const) : drafting.kind, points: this.#draft, colour: "#ff6d00", chosen: false, open: true }] : []),
  ]);
  /** The chosen vertex, as something to take hold of. */
  marks = $derived.by((): ShownMark[] => {
    const pixel = this.chosenVertex === undefined ? undefined : drawing.chosenFeature?.vertices[this.chosenVertex]?.pixel;
    return pixel ? [{ name: `${drawing.chosen} ${(this.chosenVertex ?? 0) + 1}`, role: "check", pixel, residual_px: null, chosen: true }] : [];
  });

  /** Where the photograph shows the vertices in work: its own marks as they are, others as they are computed. */
  async follow(): Promise<void> {
    const [mine, image] = [++this.#latest, this.image];
    const asked = drafting.vertices.map((one) => one.asked);
    if (!asked.length || image === undefined) {
      this.#draft = [];
      return;
    }
    const answer = await api.vertices(drafting.project, asked, image).catch(() => undefined);
    if (mine !== this.#latest || !answer) return;
    const own = (index: number): Vector2 | undefined => {
      const one = asked[index];
      return one && "marks" in one ? one.marks.find((mark) => mark.image === image)?.pixel : undefined;
    };
    this.#draft = answer.vertices.map((one, index) => own(index) ?? ("error" in one ? null : (one.pixel ?? null)));
  }

  /** A click where clicks are vertices, or near a vertex that is drawn. */
  click(pixel: Vector2, again: boolean, scale: number): void {
    if (this.image === undefined) return;
    const near = nearestVertex(drawing.features, (vertex: Vertex) => vertex.pixel, pixel, reach / scale);
    if (!drafting.takes) {
      [drawing.chosen, this.#held] = [near?.feature, near];
      return;
    }
    if (near && drafting.snap && !again) void drafting.add(near);
    else void drafting.mark({ image: this.image, pixel, sigma_px: clickSigma }, again);
  }

  /** The chosen vertex was dragged: measured anew, in this photograph on the surface, or with its other marks. */
  async moved(pixel: Vector2): Promise<void> {
    const [feature, index, image] = [drawing.chosenFeature, this.chosenVertex, this.image];
    const from = index === undefined ? undefined : feature?.vertices[index];
    if (!feature || !from || image === undefined) return;
    const others = from.marks.filter((mark) => mark.image !== null && mark.image !== image);
    const kept = from.source === "stereo" && from.marks.some((mark) => mark.image === image) ? others : [];
    const vertex = await drafting.answered({
      marks: [...kept.map((mark) => ({ image: mark.image as number, pixel: mark.pixel, sigma_px: mark.sigma_px })), { image, pixel, sigma_px: clickSigma }],
    });
    if (vertex) await drafting.redraw(feature.id, feature.layer, feature.kind, feature.vertices.map((one, at) => (at === index ? vertex : one)));
    await drawing.load(drafting.project, image);
  }
}

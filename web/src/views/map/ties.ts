// SPDX-License-Identifier: Apache-2.0
// Tie points with their error ellipses, painted by themselves: thousands of features would be slow.
import { apply } from "ol/transform";
import type { FrameState } from "ol/Map";
import Layer from "ol/layer/Layer";
import Source from "ol/source/Source";

import type { TiePoint } from "../../lib/types";
import { ellipseOf, median, roundFactor } from "./geometry";

const cell = 28; // of the screen, in which one ellipse is drawn [px]
const wanted = 7; // half the major axis of a usual ellipse [px]
const largest = 300; // an ellipse beyond this hides the others [px]

export class TieLayer extends Layer<Source> {
  readonly #points: TiePoint[];
  readonly #usual: number;
  readonly #canvas = document.createElement("canvas");
  /** How much ellipses are enlarged at present. */
  factor = 1;
  /** Called when that changes. */
  told: (factor: number) => void = () => {};

  constructor(points: TiePoint[]) {
    super({ source: new Source({}) });
    this.#points = points;
    this.#usual = median(points.slice(0, 2000).map((point) => ellipseOf(point[3], point[4], point[6] ?? 0).major)) ?? 0;
    this.#canvas.className = "ties";
  }

  override render(frame: FrameState | null): HTMLElement {
    const context = this.#canvas.getContext("2d");
    if (!frame || !context) return this.#canvas;
    const ratio = frame.pixelRatio;
    const [width = 0, height = 0] = frame.size;
    [this.#canvas.width, this.#canvas.height] = [width * ratio, height * ratio];
    this.#canvas.style.width = `${width}px`;
    this.#canvas.style.height = `${height}px`;
    this.#canvas.style.position = "absolute";
    this.#canvas.style.opacity = String(this.getOpacity());
    context.scale(ratio, ratio);
    const resolution = frame.viewState.resolution;
    const factor = roundFactor((wanted * resolution) / this.#usual);
    if (factor !== this.factor) {
      this.factor = factor;
      queueMicrotask(() => this.told(factor));
    }
    this.#paint(context, frame, width, height, factor / resolution);
    return this.#canvas;
  }

  #paint(context: CanvasRenderingContext2D, frame: FrameState, width: number, height: number, pixelsPerMetre: number): void {
    const dots = new Path2D();
    const ellipses = new Path2D();
    const taken = new Set<number>();
    const place = [0, 0];
    for (const [e, n, , se, sn, , covariance] of this.#points) {
      [place[0], place[1]] = [e, n];
      const [x = 0, y = 0] = apply(frame.coordinateToPixelTransform, place);
      if (x < -cell || y < -cell || x > width + cell || y > height + cell) continue;
      dots.rect(x - 1, y - 1, 2, 2);
      const key = Math.floor(x / cell) * 65536 + Math.floor(y / cell);
      if (taken.has(key) || !(se > 0) || !(sn > 0)) continue;
      taken.add(key);
      const { major, minor, angle } = ellipseOf(se, sn, covariance ?? 0);
      if (major * pixelsPerMetre > largest) continue;
      ellipses.moveTo(x + major * pixelsPerMetre * Math.cos(angle), y - major * pixelsPerMetre * Math.sin(angle));
      ellipses.ellipse(x, y, major * pixelsPerMetre, minor * pixelsPerMetre, -angle, 0, 2 * Math.PI);
    }
    context.lineWidth = 3;
    context.strokeStyle = "rgba(255, 255, 255, 0.75)";
    context.stroke(ellipses);
    context.lineWidth = 1.2;
    context.strokeStyle = "#00695c";
    context.stroke(ellipses);
    context.fillStyle = "#004d40";
    context.fill(dots);
  }
}

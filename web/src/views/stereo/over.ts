// SPDX-License-Identifier: Apache-2.0
// What is painted over each image of the pair: the floating mark, features and the figure that is being drawn.
import type { StereoMark } from "../../lib/stereo_types";
import type { Vector2 } from "../../lib/types";

export interface OverFeature {
  colour: string;
  closed: boolean;
  chosen: boolean;
  marks: (StereoMark | undefined)[];
}

type Context = CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;

/** Where a mark is in an image on the screen. */
export const screenOf = (mark: StereoMark, which: "left" | "right", middle: Vector2, zoom: number, width: number, height: number): Vector2 => [
  ((which === "left" ? mark[0] : mark[0] - mark[2]) - middle[0]) * zoom + width / 2,
  (mark[1] - middle[1]) * zoom + height / 2,
];

export function paintMark(context: Context, [x, y]: Vector2, ratio: number, onGround: boolean): void {
  const arm = 11 * ratio;
  const gap = 2.5 * ratio;
  for (const [colour, width] of [["#000000", 4], ["#ffffff", 1.6]] as const) {
    context.strokeStyle = colour;
    context.lineWidth = width * ratio;
    context.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) {
      context.moveTo(x + gap * dx, y + gap * dy);
      context.lineTo(x + arm * dx, y + arm * dy);
    }
    if (onGround) {
      context.moveTo(x + arm, y);
      context.arc(x, y, arm, 0, 2 * Math.PI);
    }
    context.stroke();
  }
  context.fillStyle = "#ffffff";
  context.fillRect(x - ratio / 2, y - ratio / 2, ratio, ratio);
}

export function paintFeature(context: Context, feature: OverFeature, at: (mark: StereoMark) => Vector2, ratio: number): void {
  const shown = feature.marks.map((mark) => mark && at(mark));
  for (const [colour, width] of [["#000000", feature.chosen ? 6 : 4], [feature.colour, feature.chosen ? 3.5 : 2]] as const) {
    context.strokeStyle = colour;
    context.lineWidth = width * ratio;
    context.beginPath();
    let before: Vector2 | undefined;
    for (const point of feature.closed ? [...shown, shown[0]] : shown) {
      if (point && before) context.lineTo(...point);
      else if (point) context.moveTo(...point);
      before = point;
    }
    context.stroke();
  }
  context.fillStyle = feature.colour;
  for (const point of shown) if (point) context.fillRect(point[0] - 2.5 * ratio, point[1] - 2.5 * ratio, 5 * ratio, 5 * ratio);
}

// SPDX-License-Identifier: Apache-2.0
// What is drawn over photographs, by the large view, the small ones and the loupe alike. Over all colours: each line has a dark rim.
import type { Ellipse, Residual, Vector2 } from "../../lib/types";

export type ToScreen = (pixel: Vector2) => Vector2;

export const colours = { control: "#ff4fa0", check: "#ffb300", chosen: "#ffe600", place: "#35d6ff", residual: "#ff3d2e", tie: "#7dff5a", mask: "#ff9d3b", rim: "rgba(0, 0, 0, 0.75)" };

export interface ShownMark {
  name: string;
  role: "control" | "check";
  pixel: Vector2;
  residual_px: Vector2 | null;
  chosen: boolean;
}

/** A mask, or one that is being drawn (`open`). */
export interface ShownRing {
  name: string;
  points: Vector2[];
  chosen: boolean;
  open: boolean;
}

/** A feature, or a figure that is being drawn (`open`): vertices that the photograph does not show are left out. */
export interface ShownFigure {
  kind: "point" | "line" | "polygon";
  points: (Vector2 | null)[];
  colour: string;
  chosen: boolean;
  open: boolean;
}

export function paintFigure(context: CanvasRenderingContext2D, toScreen: ToScreen, figure: ShownFigure): void {
  const points = figure.points.map((point) => point && toScreen(point));
  const isRing = figure.kind === "polygon" && points.length > 2;
  const colour = figure.chosen ? colours.chosen : figure.colour;
  lines(context, () => {
    points.forEach((point, index) => {
      const before = points[index - 1] ?? (isRing && index === 0 ? points[points.length - 1] : undefined);
      if (!point || !before || figure.kind === "point") return;
      context.moveTo(...before);
      context.lineTo(...point);
    });
  }, colour, figure.chosen ? 2.5 : 2, figure.open ? [6, 4] : []);
  if (!figure.chosen && !figure.open && figure.kind !== "point") return;
  for (const point of points) if (point) lines(context, () => context.rect(point[0] - 3, point[1] - 3, 6, 6), colour, 2);
}

export interface ShownPlace {
  name: string;
  pixel: Vector2;
  ellipse: Ellipse | null;
}

function lines(context: CanvasRenderingContext2D, path: () => void, colour: string, width = 1.5, dash: number[] = []): void {
  for (const [style, wide] of [[colours.rim, width + 2], [colour, width]] as const) {
    context.beginPath();
    path();
    context.strokeStyle = style;
    context.lineWidth = wide;
    context.setLineDash(style === colour ? dash : []);
    context.stroke();
  }
  context.setLineDash([]);
}

/** A cross whose middle is open, so that the target is seen. */
export function cross(context: CanvasRenderingContext2D, [x, y]: Vector2, colour: string, inner = 4, outer = 13, width = 1.5): void {
  lines(context, () => {
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) {
      context.moveTo(x + dx * inner, y + dy * inner);
      context.lineTo(x + dx * outer, y + dy * outer);
    }
  }, colour, width);
}

function label(context: CanvasRenderingContext2D, [x, y]: Vector2, text: string, colour: string): void {
  context.font = "600 12px system-ui, sans-serif";
  context.lineJoin = "round";
  context.strokeStyle = colours.rim;
  context.lineWidth = 3;
  context.strokeText(text, x + 15, y - 13);
  context.fillStyle = colour;
  context.fillText(text, x + 15, y - 13);
}

function arrow(context: CanvasRenderingContext2D, from: Vector2, to: Vector2, colour: string, width: number): void {
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  if (length < 1) return;
  const [ux, uy] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
  const head = Math.min(6, length / 2);
  lines(context, () => {
    context.moveTo(...from);
    context.lineTo(...to);
    context.moveTo(to[0] - head * (ux + uy / 2), to[1] - head * (uy - ux / 2));
    context.lineTo(...to);
    context.lineTo(to[0] - head * (ux - uy / 2), to[1] - head * (uy + ux / 2));
  }, colour, width);
}

const along = (toScreen: ToScreen, [x, y]: Vector2, [rx, ry]: Vector2, factor: number): Vector2 => toScreen([x + factor * rx, y + factor * ry]);

export function paintMark(context: CanvasRenderingContext2D, toScreen: ToScreen, mark: ShownMark, factor: number): void {
  const at = toScreen(mark.pixel);
  const colour = mark.chosen ? colours.chosen : colours[mark.role];
  if (mark.residual_px && factor > 0) arrow(context, at, along(toScreen, mark.pixel, mark.residual_px, factor), colours.residual, 2);
  cross(context, at, colour, 4, mark.chosen ? 16 : 11, mark.chosen ? 2 : 1.5);
  label(context, at, mark.name, colour);
}

/** Where a point is expected: its ellipse of one standard deviation, `scale` pixels of the screen per native one. */
export function paintPlace(context: CanvasRenderingContext2D, toScreen: ToScreen, place: ShownPlace, scale: number): void {
  const [x, y] = toScreen(place.pixel);
  cross(context, [x, y], colours.place, 1.5, 4.5, 1.2);
  const { ellipse } = place;
  if (ellipse) {
    const [major, minor] = [Math.max(3, ellipse.major_px * scale), Math.max(3, ellipse.minor_px * scale)];
    lines(context, () => context.ellipse(x, y, major, minor, (ellipse.angle_deg * Math.PI) / 180, 0, 2 * Math.PI), colours.place, 1.5, [5, 3]);
  }
  if (place.name) label(context, [x, y], place.name, colours.place);
}

/** What masks hide is dimmed. One that is being drawn shows its corners, and the side that would close it. */
export function paintRing(context: CanvasRenderingContext2D, toScreen: ToScreen, ring: ShownRing): void {
  const points = ring.points.map(toScreen);
  const [first] = points;
  if (!first) return;
  const path = (): void => {
    points.forEach((point, index) => (index ? context.lineTo(...point) : context.moveTo(...point)));
    if (!ring.open) context.closePath();
  };
  context.beginPath();
  path();
  context.fillStyle = "rgba(0, 0, 0, 0.45)";
  context.fill();
  const colour = ring.chosen || ring.open ? colours.chosen : colours.mask;
  lines(context, path, colour, ring.chosen ? 2.5 : 1.5);
  if (ring.open) {
    for (const [x, y] of points) lines(context, () => context.rect(x - 3, y - 3, 6, 6), colour);
    const last = points[points.length - 1] ?? first;
    lines(context, () => {
      context.moveTo(...last);
      context.lineTo(...first);
    }, colour, 1, [4, 4]);
  }
  if (ring.name) label(context, first, ring.name, colour);
}

/** Thousands of residuals at tie points: one path. */
export function paintResiduals(context: CanvasRenderingContext2D, toScreen: ToScreen, points: readonly Residual[], factor: number): void {
  lines(context, () => {
    for (const [x, y, rx, ry] of points) {
      const from = toScreen([x, y]);
      context.moveTo(...from);
      context.lineTo(...along(toScreen, [x, y], [rx, ry], factor));
      context.rect(from[0] - 0.75, from[1] - 0.75, 1.5, 1.5);
    }
  }, colours.tie, 1.2);
}

// SPDX-License-Identifier: Apache-2.0
// Points and photographs in the order of work, and what of them is beyond its limit.
import type { ControlPoint, MarkedPoint, Place } from "../../lib/types";

/** Two-sided at a level of 0.1 %, of one normally distributed residual (Baarda 1968). */
export const wLimit = 3.29;
/** A difference beyond so many of its standard deviations is doubted. */
export const differenceLimit = 3;

export interface Difference {
  axis: "E" | "N" | "H";
  metres: number;
  sigma_m: number | null;
}

const axes = ["E", "N", "H"] as const;
const sizeOf = (one: Difference): number => (one.sigma_m ? Math.abs(one.metres) / one.sigma_m : Math.abs(one.metres));

/** The coordinate that differs most, in its standard deviations; nothing where no difference is known. */
export function worstDifference(difference: (number | null)[] | null | undefined, sigma: (number | null)[] | null | undefined): Difference | undefined {
  const known = axes.flatMap((axis, at) => {
    const metres = difference?.[at];
    return typeof metres === "number" ? [{ axis, metres, sigma_m: sigma?.[at] ?? null }] : [];
  });
  return known.sort((a, b) => sizeOf(b) - sizeOf(a))[0];
}

export const isDoubted = (one: Difference | undefined): boolean => !!one && !!one.sigma_m && Math.abs(one.metres) > differenceLimit * one.sigma_m;

/** The largest in absolute size; nothing of nothing. */
export function largest(values: readonly (number | null | undefined)[]): number | undefined {
  const known = values.filter((one): one is number => typeof one === "number" && Number.isFinite(one));
  return known.sort((a, b) => Math.abs(b) - Math.abs(a))[0];
}

export const worstW = (point: ControlPoint): number | undefined => largest(point.marks.map((mark) => mark.w));

export const columns = ["name", "role", "marks", "difference", "w"] as const;
export type Column = (typeof columns)[number];

const byName = (a: ControlPoint, b: ControlPoint): number => a.name.localeCompare(b.name, "en", { numeric: true });
const significance = (point: ControlPoint): number => {
  const worst = worstDifference(point.difference_m, point.difference_sigma_m);
  return worst ? sizeOf(worst) : -1;
};
// The one to look at first comes first.
const orders: Record<Column, (a: ControlPoint, b: ControlPoint) => number> = {
  name: byName,
  role: (a, b) => b.role.localeCompare(a.role),
  marks: (a, b) => a.marks.length - b.marks.length,
  difference: (a, b) => significance(b) - significance(a),
  w: (a, b) => Math.abs(worstW(b) ?? 0) - Math.abs(worstW(a) ?? 0),
};

export function sorted(points: readonly ControlPoint[], column: Column, isReversed: boolean): ControlPoint[] {
  return [...points].sort((a, b) => (isReversed ? -1 : 1) * orders[column](a, b) || byName(a, b));
}

export const placeOrders = ["best", "marked", "name"] as const;
export type PlaceOrder = (typeof placeOrders)[number];

/** As the server has them (those that help most first, marked ones last), marked ones first, or by name. */
export function placesInOrder(places: readonly Place[], order: PlaceOrder): Place[] {
  if (order === "best") return [...places];
  if (order === "name") return [...places].sort((a, b) => a.file.localeCompare(b.file, "en", { numeric: true }));
  return [...places].sort((a, b) => Number(b.marked) - Number(a.marked)); // else as they were
}

/**
 * The one to mark next: the best that is not marked, another than the one that is looked at, and of those that were gone by the ones that came before only
 * where there are no others; nothing: all are.
 */
export const nextPlace = (places: readonly Place[], image: number | undefined, passed: ReadonlySet<number> = new Set()): Place | undefined => {
  const open = places.filter((place) => !place.marked && place.image !== image);
  return open.find((place) => !passed.has(place.image)) ?? open[0];
};

/** The point behind another in a ring. */
export function nextPoint(points: readonly ControlPoint[], name: string, step = 1): ControlPoint | undefined {
  const at = points.findIndex((point) => point.name === name);
  return points[(at + step + points.length) % points.length] ?? points[0];
}

/** Pixels of the screen per native one, so that an ellipse of three standard deviations is seen in a small window. */
export function chipScale(place: Place, width: number, usual = 2): number {
  const reach = place.ellipse ? 6 * place.ellipse.major_px : 0;
  return reach > 0 ? Math.min(usual, width / reach) : usual;
}

export interface MarkTests {
  residual_px: (number | null)[] | null;
  w: number | null;
  redundancy: number | null;
  detectable_px: number | null;
}

/** Of the marks as they are now, in the whole block or, without that, among those of the point; else what the adjustment said. */
export function testsOf(point: ControlPoint, image: number, marked: Pick<MarkedPoint, "marks"> | null | undefined): MarkTests {
  const now = marked?.marks.find((one) => one.image === image);
  if (now) {
    const [redundancy] = now.redundancy.filter((one) => typeof one === "number").sort((a, b) => (a ?? 0) - (b ?? 0));
    return { residual_px: now.residual_px, w: largest(now.w) ?? null, redundancy: redundancy ?? null, detectable_px: largest(now.detectable_px) ?? null };
  }
  const adjusted = point.marks.find((one) => one.image === image);
  return { residual_px: adjusted?.residual_px ?? null, w: adjusted?.w ?? null, redundancy: adjusted?.redundancy ?? null, detectable_px: adjusted?.detectable_px ?? null };
}

// SPDX-License-Identifier: Apache-2.0
// Where a ray of the view means a place of the cloud: on the plane of the points about the one that was picked. A point of the cloud lies somewhere within
// its spacing of a corner; the ray goes where the person points.
import type { PickRay, PlacedPoint, PickedPoint } from "./messages";
import { cross, dot, sum, type Triple, unit } from "./viewpoint";

/** Points about the one that was picked, in the map; those of the cloud that are nearest to it. */
export interface Neighbour {
  at: Triple;
  sigma_m: number;
}

const leastOnPlane = 8;
const leastSine = 0.2; // between ray and plane: at smaller angles the plane says little of where the ray meets it
const seeds = 24; // of the nearest neighbours, whose pairs make planes with the point
const tolerance = 2.5; // in standard deviations
/**
 * What the rim of a surface is uncertain by in a cloud, in spacings of its points: matching windows smear edges of heights. Corners of roofs of a rendered
 * village stood 2.7 of them off where the cloud shows them, in the root mean square of a coordinate.
 */
export const rimSpacings = 3;

const minus = (a: Triple, b: Triple): Triple => sum(a, b, -1);

/** The plane about a place by least squares: its normal and the mean of its points. */
function fitted(points: Triple[], towards: Triple): { normal: Triple; mean: Triple } | undefined {
  const mean = points.reduce((all, one) => sum(all, one, 1 / points.length), [0, 0, 0] as Triple);
  // Heights over a base square to `towards`: exact where the plane is not edge-on, and that is asked for.
  const u = unit(cross(towards, Math.abs(towards[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  const v = cross(towards, u);
  let [uu, uv, vv, uw, vw] = [0, 0, 0, 0, 0];
  for (const one of points) {
    const by = minus(one, mean);
    const [a, b, w] = [dot(by, u), dot(by, v), dot(by, towards)];
    [uu, uv, vv, uw, vw] = [uu + a * a, uv + a * b, vv + b * b, uw + a * w, vw + b * w];
  }
  const determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-6 * uu * vv)) return undefined; // on a line
  const [p, q] = [(uw * vv - vw * uv) / determinant, (vw * uu - uw * uv) / determinant];
  return { normal: unit(sum(sum(towards, u, -p), v, -q)), mean };
}

/** The mean distance of a point to the nearest other one, over the points nearest to a place. */
export function spacingOf(neighbours: Neighbour[]): number {
  const some = neighbours.slice(0, 16);
  const nearest = some.map((one) => Math.min(...neighbours.filter((other) => other !== one).map((other) => Math.hypot(...minus(one.at, other.at)))));
  return nearest.reduce((all, one) => all + one, 0) / Math.max(nearest.length, 1);
}

/** Of planes through the picked point and two neighbours the one that most of them lie on, fitted to these; nothing: there is none to speak of. */
function planeAbout(picked: PickedPoint, neighbours: Neighbour[], direction: Triple): { normal: Triple; mean: Triple; spread_m: number; on: Triple[] } | undefined {
  const towards = minus([0, 0, 0], direction);
  const noise = (one: Neighbour): number => tolerance * Math.max(one.sigma_m, picked.sigma_m ?? 0, 1e-3);
  const near = neighbours.slice(0, seeds);
  let [best, most] = [[] as Triple[], 0];
  for (let i = 0; i < near.length; ++i)
    for (let j = 0; j < i; ++j) {
      const across = cross(minus((near[i] as Neighbour).at, picked.at), minus((near[j] as Neighbour).at, picked.at));
      const size = Math.hypot(...across);
      if (size < 1e-9) continue;
      const normal = across.map((one) => one / size) as Triple;
      if (Math.abs(dot(normal, direction)) < leastSine) continue;
      const on = neighbours.filter((one) => Math.abs(dot(normal, minus(one.at, picked.at))) < noise(one));
      if (on.length > most) [best, most] = [on.map((one) => one.at), on.length];
    }
  if (most < leastOnPlane) return undefined;
  const plane = fitted(best, towards);
  if (!plane || Math.abs(dot(plane.normal, direction)) < leastSine) return undefined;
  const squares = best.reduce((all, one) => all + dot(plane.normal, minus(one, plane.mean)) ** 2, 0);
  return { ...plane, spread_m: Math.sqrt(squares / Math.max(best.length - 3, 1)), on: best };
}

/**
 * The vertex that a click on a point of the cloud means, with standard deviations along the axes of the map. `pointing_m`: of the click, across the ray at the
 * point. Where no plane is: the point itself, as uncertain as it is far from the ray.
 */
export function placedBy(ray: PickRay, picked: PickedPoint, neighbours: Neighbour[], pointing_m: number): PlacedPoint {
  const { direction } = ray;
  const spacing = spacingOf(neighbours);
  const across = Math.hypot(pointing_m, rimSpacings * spacing);
  const plane = planeAbout(picked, neighbours, direction);
  const t = plane ? dot(plane.normal, minus(plane.mean, ray.origin)) / dot(plane.normal, direction) : 0;
  const met = sum(ray.origin, direction, t);
  const off = Math.hypot(...minus(met, picked.at));
  if (plane && off < 3 * spacing + 3 * pointing_m) {
    // Neighbours are matched by windows that overlap: what they have in common stays in the plane.
    const height = Math.hypot(picked.sigma_m ?? plane.spread_m, plane.spread_m / Math.sqrt(plane.on.length));
    return { ...picked, at: met, sigmas_m: sigmasOf(plane.normal, direction, height, across) };
  }
  const by = minus(picked.at, ray.origin);
  const aside = Math.hypot(...minus(by, direction.map((one) => one * dot(by, direction)) as Triple));
  const along = Math.hypot(picked.sigma_m ?? spacing, spacing);
  return { ...picked, sigmas_m: sigmasOf(direction, direction, along, Math.hypot(across, aside)) };
}

/** An error across the ray slides along the plane; one of the plane's height moves the meeting along the ray. */
function sigmasOf(normal: Triple, direction: Triple, height: number, across: number): Triple {
  const along = dot(normal, direction);
  const u = unit(cross(direction, Math.abs(direction[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  const slides = [u, cross(direction, u)].map((one) => sum(one, direction, -dot(normal, one) / along));
  const shares = [...slides.map((one) => one.map((value) => across * value)), direction.map((value) => (height * value) / along)];
  return [0, 1, 2].map((axis) => Math.hypot(...shares.map((one) => one[axis] as number))) as Triple;
}

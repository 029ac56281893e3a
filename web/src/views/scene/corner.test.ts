// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { type Neighbour, placedBy, spacingOf } from "./corner";
import type { PickedPoint, PickRay } from "./messages";
import { dot, sum, type Triple, unit } from "./viewpoint";

let seed = 3;
const uniform = (): number => (seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648;
const normal = (): number => Math.sqrt(-2 * Math.log(uniform() || 1e-9)) * Math.cos(2 * Math.PI * uniform());

const sigma_m = 0.02;
/** A roof that slopes, with a corner at 0, 0, and level ground 6 m below the corner. */
const roofHeight = (x: number, y: number): number => 0.4 * x + 0.1 * y;
function cloud(spacing: number): Neighbour[] {
  const points: Neighbour[] = [];
  for (let i = -12; i < 12; ++i)
    for (let j = -12; j < 12; ++j) {
      const [x, y] = [i, j].map((one) => spacing * (one + 0.5 + 0.3 * (uniform() - 0.5))) as [number, number];
      const isRoof = x > 0 && y > 0;
      points.push({ at: [x, y, (isRoof ? roofHeight(x, y) : -6) + sigma_m * normal()], sigma_m });
    }
  return points;
}

/** What the worker does: the point nearest to the ray, and those about it. */
function clicked(points: Neighbour[], ray: PickRay): [PickedPoint, Neighbour[]] {
  const off = (one: Neighbour): number => {
    const by = sum(one.at, ray.origin, -1);
    const along = dot(by, ray.direction);
    return along + 8 * Math.hypot(...sum(by, ray.direction, -along));
  };
  const best = points.reduce((a, b) => (off(b) < off(a) ? b : a));
  const away = (one: Neighbour): number => Math.hypot(...sum(one.at, best.at, -1));
  return [{ at: best.at, sigma_m: best.sigma_m, class: 6, images: 4 }, [...points].sort((a, b) => away(a) - away(b)).slice(0, 96)];
}

// Coordinates of 200 corners: 95 of 100 within two standard deviations are meant, and the pointing is all that errs across the ray here.
test("a corner that is pointed at lies where the ray meets the roof, and errs as it is said", () => {
  const pointing = 0.1;
  const squares: number[] = [];
  for (const direction of [[0.01, 0.02, -1], [0.5, 0.2, -1], [-0.3, 0.6, -0.7]].map((one) => unit(one as Triple)))
    for (let i = 0; i < 40; ++i) {
      const points = cloud(0.02);
      const aim: Triple = sum([0, 0, 0], [pointing * normal(), pointing * normal(), pointing * normal()]);
      const ray: PickRay = { origin: sum(aim, direction, -50), direction, radius_m: 0.5, slope: 0 };
      const [picked, neighbours] = clicked(points, ray);
      const placed = placedBy(ray, picked, neighbours, pointing);
      if (Math.abs(placed.at[2]) > 1) continue; // it went by the corner to the ground
      placed.at.forEach((value, axis) => squares.push((value / (placed.sigmas_m[axis] as number)) ** 2));
    }
  const mean = squares.reduce((all, one) => all + one, 0) / squares.length;
  expect(squares.length).toBeGreaterThan(200);
  // The rim, which these clouds have not got, is counted as well: 0.06 m beside the 0.1 m of pointing.
  expect(mean).toBeGreaterThan(0.5);
  expect(mean).toBeLessThan(1);
}, 120_000);

test("where no plane is, the point itself is taken, as uncertain as it is far from the ray", () => {
  const ray: PickRay = { origin: [0, 0, 50], direction: [0, 0, -1], radius_m: 1, slope: 0 };
  const picked: PickedPoint = { at: [0.4, 0, 0], sigma_m, class: 6, images: 3 };
  const placed = placedBy(ray, picked, [{ at: [0.4, 0, 0], sigma_m }, { at: [0.9, 0.1, 0.3], sigma_m }], 0.05);
  expect(placed.at).toEqual([0.4, 0, 0]);
  expect(placed.sigmas_m[0]).toBeGreaterThan(0.4);
  expect(placed.sigmas_m[2]).toBeGreaterThan(0.3);
});

test("the spacing of points is that of a grid", () => {
  const grid: Neighbour[] = [];
  for (let i = 0; i < 10; ++i) for (let j = 0; j < 10; ++j) grid.push({ at: [0.25 * i, 0.25 * j, 0], sigma_m });
  expect(spacingOf(grid)).toBeCloseTo(0.25, 9);
});

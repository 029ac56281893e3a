// SPDX-License-Identifier: Apache-2.0
// The mathematics of the pair: mark, world, map and pixels of the photographs (docs/theory/stereo.md, "Stereoplotting").
import type { PixelLattice, StereoGeometry, StereoMark } from "../../lib/stereo_types";
import type { Vector2, Vector3 } from "../../lib/types";

const nan: Vector2 = [NaN, NaN];

/** Where the photograph shows a position of its epipolar image: bilinear between nodes; NaN where it shows nothing. */
export function pixelAt(lattice: PixelLattice, x: number, y: number): Vector2 {
  const [u, v] = [x / lattice.step_px, y / lattice.step_px];
  if (!(u >= 0 && v >= 0 && u <= lattice.columns - 1 && v <= lattice.rows - 1)) return nan;
  const [i, j] = [Math.min(Math.floor(u), lattice.columns - 2), Math.min(Math.floor(v), lattice.rows - 2)];
  const [a, b] = [u - i, v - j];
  const at = (axis: 0 | 1): number => {
    const node = (column: number, row: number): number => lattice.nodes[2 * (row * lattice.columns + column) + axis] ?? NaN;
    return (1 - b) * ((1 - a) * node(i, j) + a * node(i + 1, j)) + b * ((1 - a) * node(i, j + 1) + a * node(i + 1, j + 1));
  };
  return [at(0), at(1)];
}

export class Geometry {
  constructor(readonly of: StereoGeometry) {}

  get #infinity(): number {
    return this.of.left.cx - this.of.right.cx;
  }

  depthOf(parallax: number): number {
    return (this.of.focal_px * this.of.base_m) / (parallax - this.#infinity);
  }
  parallaxAt(depth: number): number {
    return this.#infinity + (this.of.focal_px * this.of.base_m) / depth;
  }

  /** In the world; nothing: the rays do not meet before the cameras. */
  positionOf([x, y, parallax]: StereoMark): Vector3 | undefined {
    const depth = this.depthOf(parallax);
    return depth > 0 && Number.isFinite(depth) ? this.#along(x, y, depth) : undefined;
  }

  /** Nothing: behind the cameras. */
  markAt(world: Vector3): StereoMark | undefined {
    const { rotation: r, translation: t } = this.of.left_from_world;
    const row = (k: number): number => (r[3 * k] ?? 0) * world[0] + (r[3 * k + 1] ?? 0) * world[1] + (r[3 * k + 2] ?? 0) * world[2] + (t[k] ?? 0);
    const [x, y, z] = [row(0), row(1), row(2)];
    if (!(z > 0)) return undefined;
    return [(this.of.focal_px * x) / z + this.of.left.cx, (this.of.focal_px * y) / z + this.of.left.cy, this.parallaxAt(z)];
  }

  mapOf(world: Vector3): Vector3 {
    const terms = this.#terms(world);
    return this.of.map.coefficients.map((row) => row.reduce((sum, one, k) => sum + one * (terms[k] ?? 0), 0)) as Vector3;
  }

  /** The other way, by Newton's steps. */
  worldOf(map: Vector3): Vector3 {
    let at: Vector3 = [...this.of.map.origin];
    for (let turn = 0; turn < 6; ++turn) {
      const is = this.mapOf(at);
      const step = solved(this.#derivatives(at), [map[0] - is[0], map[1] - is[1], map[2] - is[2]]);
      at = [at[0] + step[0], at[1] + step[1], at[2] + step[2]];
      if (Math.hypot(...step) < 1e-7) break;
    }
    return at;
  }

  /** The mark at a position of the left image and a height of the map; nothing: its ray does not come there. */
  markAtHeight(x: number, y: number, height: number, from: number): StereoMark | undefined {
    let depth = this.depthOf(from);
    if (!(depth > 0)) return undefined;
    for (let turn = 0; turn < 8; ++turn) {
      const step = depth * 1e-4;
      const here = this.mapOf(this.#along(x, y, depth))[2];
      const slope = (this.mapOf(this.#along(x, y, depth + step))[2] - here) / step;
      const next = depth + (height - here) / slope;
      if (!(next > 0) || !Number.isFinite(next)) return undefined;
      const moved = Math.abs(next - depth);
      depth = next;
      if (moved < 1e-7 * depth) return [x, y, this.parallaxAt(depth)];
    }
    return undefined;
  }

  /** What a pixel of parallax is in height, m. */
  heightOfPixel(parallax: number): number {
    const depth = this.depthOf(parallax);
    return (depth * depth) / (this.of.focal_px * this.of.base_m);
  }

  #along(x: number, y: number, depth: number): Vector3 {
    const { rotation: r, translation: t } = this.of.left_from_world;
    const p = [(depth * (x - this.of.left.cx)) / this.of.focal_px - t[0], (depth * (y - this.of.left.cy)) / this.of.focal_px - t[1], depth - t[2]];
    const column = (k: number): number => (r[k] ?? 0) * (p[0] ?? 0) + (r[3 + k] ?? 0) * (p[1] ?? 0) + (r[6 + k] ?? 0) * (p[2] ?? 0);
    return [column(0), column(1), column(2)];
  }

  #terms(world: Vector3): number[] {
    const { origin, scale_m } = this.of.map;
    const [x, y, z] = [(world[0] - origin[0]) / scale_m, (world[1] - origin[1]) / scale_m, (world[2] - origin[2]) / scale_m];
    return [1, x, y, z, x * x, x * y, x * z, y * y, y * z, z * z];
  }

  #derivatives(world: Vector3): number[][] {
    const { origin, scale_m, coefficients } = this.of.map;
    const [x, y, z] = [(world[0] - origin[0]) / scale_m, (world[1] - origin[1]) / scale_m, (world[2] - origin[2]) / scale_m];
    return coefficients.map((row) => {
      const c = (k: number): number => row[k] ?? 0;
      return [
        (c(1) + 2 * c(4) * x + c(5) * y + c(6) * z) / scale_m,
        (c(2) + c(5) * x + 2 * c(7) * y + c(8) * z) / scale_m,
        (c(3) + c(6) * x + c(8) * y + 2 * c(9) * z) / scale_m,
      ];
    });
  }
}

/** Three equations, by Cramer's rule: the derivatives are nearly a rotation. */
function solved(m: number[][], right: Vector3): Vector3 {
  const at = (i: number, j: number): number => m[i]?.[j] ?? 0;
  const determinant = (col: (i: number, j: number) => number): number =>
    col(0, 0) * (col(1, 1) * col(2, 2) - col(1, 2) * col(2, 1)) - col(0, 1) * (col(1, 0) * col(2, 2) - col(1, 2) * col(2, 0)) + col(0, 2) * (col(1, 0) * col(2, 1) - col(1, 1) * col(2, 0));
  const all = determinant(at);
  const with_ = (k: number): number => determinant((i, j) => (j === k ? (right[i] ?? 0) : at(i, j))) / all;
  return [with_(0), with_(1), with_(2)];
}

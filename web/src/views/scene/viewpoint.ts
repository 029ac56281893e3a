// SPDX-License-Identifier: Apache-2.0
// From where the scene is looked at: about a target, north up or turned, from above to level. Coordinates are local (east, north, up) [m].

import type { Vector3 } from "../../lib/types";

/** Three has a class of the other name. */
export type Triple = Vector3;

const fieldOfView = (50 * Math.PI) / 180;
const fitRim = 0.05; // of half the view, that stays free about all that there is

export interface Axes {
  forward: Triple;
  up: Triple;
  right: Triple;
}

export const sum = (a: Triple, b: Triple, factor = 1): Triple => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
export const dot = (a: Triple, b: Triple): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Triple, b: Triple): Triple => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a: Triple, by: number): Triple => [by * a[0], by * a[1], by * a[2]];
export const unit = (a: Triple): Triple => {
  const size = Math.hypot(...a) || 1;
  return [a[0] / size, a[1] / size, a[2] / size];
};

export class Viewpoint {
  target: Triple = [0, 0, 0];
  /** From the eye to the target; of a parallel view what a perspective one of the same scale would have. */
  distance = 100;
  /** Of the view, clockwise from north [rad]. */
  heading = 0;
  /** 0: straight down; pi/2: level [rad]. */
  tilt = 0.9;
  /** About the view, clockwise as it is seen; only while a photograph is looked through [rad]. */
  roll = 0;
  isParallel = false;
  /** Of the height of the view [rad]; only while a photograph is looked through another one. */
  fov = fieldOfView;

  get axes(): Axes {
    const [s, c, sh, ch] = [Math.sin(this.tilt), Math.cos(this.tilt), Math.sin(this.heading), Math.cos(this.heading)];
    const [up, right]: [Triple, Triple] = [[sh * c, ch * c, s], [ch, -sh, 0]];
    const [sr, cr] = [Math.sin(this.roll), Math.cos(this.roll)];
    return { forward: [sh * s, ch * s, -c], up: sum(scaled(up, cr), right, sr), right: sum(scaled(right, cr), up, -sr) };
  }
  get eye(): Triple {
    return sum(this.target, this.axes.forward, -this.distance);
  }
  /** Half of what the view is high at the target [m]. */
  get halfHeight(): number {
    return this.distance * Math.tan(this.fov / 2);
  }

  turn(heading: number, tilt: number): void {
    this.heading += heading;
    this.tilt = Math.min(Math.max(this.tilt + tilt, 0), 0.98 * Math.PI);
  }

  /** By parts of the view's height, to the right and upwards. */
  pan(right: number, up: number): void {
    const { axes, halfHeight } = this;
    this.target = sum(sum(this.target, axes.right, 2 * halfHeight * right), axes.up, 2 * halfHeight * up);
  }

  /** By a factor about a place, which stays where it is on the screen. */
  zoom(factor: number, about: Triple = this.target): void {
    const wanted = Math.min(Math.max(this.distance * factor, 0.05), 1e7);
    const applied = wanted / this.distance;
    this.target = this.target.map((along, axis) => (about[axis] as number) + (along - (about[axis] as number)) * applied) as Triple;
    this.distance = wanted;
  }

  look(heading: number, tilt: number): void {
    [this.heading, this.tilt, this.roll] = [heading, tilt, 0];
  }

  /** Along a direction, with what is up in the view. */
  lookAlong(forward: Triple, up: Triple): void {
    const along = unit(forward);
    const flat = Math.hypot(along[0], along[1]);
    this.look(flat > 1e-9 ? Math.atan2(along[0], along[1]) : 0, Math.acos(Math.min(Math.max(-along[2], -1), 1)));
    const axes = this.axes;
    this.roll = Math.atan2(dot(up, axes.right), dot(up, axes.up));
  }

  /** Without a roll, in the usual field of view; seen from above what is up in the view stays up. */
  level(): void {
    const { up } = this.axes;
    if (this.tilt < 0.6 && this.roll !== 0) this.heading = Math.atan2(up[0], up[1]);
    [this.roll, this.fov] = [0, fieldOfView];
  }

  /** Every place of a box, with a rim about it, as it is looked at now. */
  fit(low: Triple, high: Triple, aspect: number): void {
    const { right, up, forward } = this.axes;
    const tangent = Math.tan(this.fov / 2) * (1 - fitRim);
    this.target = sum(low, sum(high, low, -1), 0.5);
    this.distance = 1;
    for (let corner = 0; corner < 8; ++corner) {
      const by = sum([0, 1, 2].map((axis) => ((corner >> axis) & 1 ? high : low)[axis]) as Triple, this.target, -1);
      const aside = Math.max(Math.abs(dot(by, up)), Math.abs(dot(by, right)) / aspect);
      this.distance = Math.max(this.distance, aside / tangent - (this.isParallel ? 0 : dot(by, forward)));
    }
  }

  /** A ray through a place of the view: x and y from -1 (left, below) to 1. */
  ray(x: number, y: number, aspect: number): { origin: Triple; direction: Triple } {
    const { axes, eye, halfHeight } = this;
    const [right, up] = [x * aspect * halfHeight, y * halfHeight];
    const there = sum(sum(this.target, axes.right, right), axes.up, up);
    if (!this.isParallel) return { origin: eye, direction: unit(sum(there, eye, -1)) };
    return { origin: sum(there, axes.forward, -20 * this.distance), direction: axes.forward };
  }

  /** Where a ray meets the plane through a place that is square to the view. */
  onPlane(ray: { origin: Triple; direction: Triple }, place: Triple = this.target): Triple {
    const { forward } = this.axes;
    const along = dot(sum(place, ray.origin, -1), forward) / (dot(ray.direction, forward) || 1);
    return sum(ray.origin, ray.direction, along);
  }
}

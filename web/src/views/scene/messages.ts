// SPDX-License-Identifier: Apache-2.0
// What the view and its worker say to each other. Positions are in the map unless "relative": then to the middle of their node.
import type { CloudRegion } from "../../lib/types";
import type { CloudHeader, CloudNode } from "./cloud_file";
import type { Triple } from "./viewpoint";

/** Half of a view ray's cone: `radius_m` at the origin, and so much more for every metre. */
export interface PickRay {
  origin: Triple;
  direction: Triple;
  radius_m: number;
  slope: number;
}

export type ToWorker =
  | { open: string; regions: CloudRegion[] }
  | { load: number }
  | { drop: number[] }
  | { cancel: number[] }
  | { regions: CloudRegion[] }
  /** With `pointing_m` the place is answered that the ray means, where it goes by a point that is picked. */
  | { pick: PickRay; among: number[]; ask: number; pointing_m?: number };

export interface PickedPoint {
  at: Triple;
  /** null: not known. */
  sigma_m: number | null;
  class: number;
  images: number;
}

/** A place on the surface of the cloud, with standard deviations along the axes of the map. */
export interface PlacedPoint extends PickedPoint {
  sigmas_m: Triple;
}

export interface LoadedNode {
  /** Index of the node. */
  node: number;
  /** x, y, z relative. */
  positions: Float32Array;
  /** Red, green, blue, and 255 (0: removed by an edit). */
  colours: Uint8Array;
  /** Class, standard deviation (`sigmaCode`), images, 0. */
  traits: Uint8Array;
  /** Of the root: what most of its points lie between. */
  spread?: Spread;
}

/** From the 2 % to the 98 % quantile; standard deviations as `sigmaCode`, heights in the map. */
export type Spread = Record<"height" | "sigma" | "images", [number, number]>;

export type FromWorker =
  | { opened: CloudHeader; nodes: CloudNode[] }
  | { failed: string }
  | { loaded: LoadedNode }
  | { missed: number; why: string }
  /** Colours and traits as the regions now have them. */
  | { edited: number; colours: Uint8Array; traits: Uint8Array }
  /** All nodes have the regions that were told last, or before. */
  | { applied: true }
  | { picked: PickedPoint | PlacedPoint | null; ask: number };

/** Standard deviations in a byte, by the logarithm: steps of 4.4 % from 0.1 mm; 0: not known. */
export const sigmaCode = (sigma_m: number): number => (sigma_m > 0 ? Math.min(Math.max(Math.round(16 * Math.log2(sigma_m / 1e-4)) + 1, 1), 255) : 0);
export const sigmaOfCode = (code: number): number => 1e-4 * 2 ** ((code - 1) / 16);

// SPDX-License-Identifier: Apache-2.0
// The stereoplotter as the server states it (docs/manual/serve.md, "Stereo"). Parallax: column left less column right, in
// pixels of the epipolar images.
import type { Vector2, Vector3 } from "./types";

/** x and y in the left epipolar image, parallax. */
export type StereoMark = [number, number, number];

export interface PixelLattice {
  step_px: number;
  columns: number;
  rows: number;
  error_px: number;
  /** Pixels of the photograph, x and y of each node by rows; null: nothing there. */
  nodes: (number | null)[];
}

export interface StereoSide {
  image: number;
  file: string;
  width: number;
  height: number;
  levels: number;
  columns: number;
  rows: number;
  cx: number;
  cy: number;
  lattice: PixelLattice;
}

export interface StereoChoice {
  images: [number, number];
  files: [string, string];
  base_to_height: number;
  convergence_rad: number;
  gsd_m: Vector2;
  sigma_height_m: number | null;
  /** By the surface, in one of the two. */
  hidden: boolean;
}

export interface StereoGeometry {
  focal_px: number;
  base_m: number;
  left_from_world: { rotation: number[]; translation: Vector3 };
  left: Pick<StereoSide, "cx" | "cy">;
  right: Pick<StereoSide, "cx" | "cy">;
  map: { origin: Vector3; scale_m: number; coefficients: number[][] };
}

export interface StereoPlace extends StereoChoice, StereoGeometry {
  left: StereoSide;
  right: StereoSide;
  mark: StereoMark;
  position: Vector3;
  sigma_m: Vector3 | null;
  pairs: StereoChoice[];
}

export interface Ground {
  mark: StereoMark;
  sigma_px: number;
  /** Of each of the two marks. */
  mark_sigma_px: number;
  correlation: number;
  position: Vector3;
  sigma_m: Vector3 | null;
  pixels: [Vector2, Vector2];
}

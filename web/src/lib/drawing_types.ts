// SPDX-License-Identifier: Apache-2.0
// Vertices, features and figures as the server states them (docs/manual/serve.md, "Drawing").
import type { Vector2, Vector3 } from "./types";

export type FeatureKind = "point" | "line" | "polygon";
export type VertexSource = "stereo" | "mono" | "surface" | "cloud" | "typed";

export interface AskedMark {
  image: number;
  pixel: Vector2;
  sigma_px?: number;
}

/** What a person did: marked it, clicked on the map, took a known place, or snapped to a vertex that is there. */
export type AskedVertex =
  | { marks: AskedMark[] }
  | { surface: Vector2 }
  | { at: Vector3; sigma_m?: number | Vector3 | null; source?: "cloud" | "typed" }
  | { feature: string; vertex: number };

export interface VertexMark {
  /** null: a photograph that the project does not have (any more). */
  image: number | null;
  file: string;
  pixel: Vector2;
  sigma_px: number;
  residual_px?: Vector2 | null;
}

export interface Vertex {
  position: Vector3;
  /** EE, EN, EH, NN, NH, HH; null: not known. */
  covariance_m2: [number, number, number, number, number, number] | null;
  sigma_m: Vector3 | null;
  source: VertexSource;
  marks: VertexMark[];
  /** Where the photograph that was asked about shows it. */
  pixel?: Vector2 | null;
}

export interface Feature {
  id: string;
  layer: string;
  kind: FeatureKind;
  attributes: Record<string, string>;
  vertices: Vertex[];
  /** How far computing it anew in the adjustment in force moved a vertex, also in its standard deviations; null: none has marks. */
  moved_m?: number | null;
  moved_sigmas?: number | null;
  /** Vertices, from 0, that are as they were drawn, and why. */
  not_computed?: { vertex: number; error: string }[];
}

export interface DrawingLayer {
  name: string;
  kind: FeatureKind | null;
  colour: string;
}

export interface Code {
  code: string;
  layer: string;
  kind: FeatureKind;
  colour: string;
  meaning: string;
}

export interface Drawing {
  layers: DrawingLayer[];
  codes: Code[];
  features: Feature[];
}

export type FigureKind = "distance" | "plan_distance" | "height_difference" | "slope" | "angle" | "length" | "area" | "plan_area";

export interface MeasuredFigure {
  kind: FigureKind;
  value: number;
  sigma: number | null;
  unit: "m" | "m2" | "rad";
}

export interface MeasuredVolume {
  above_m3: number;
  below_m3: number;
  net_m3: number;
  sigma_m3: number;
  area_m2: number;
  missing_m2: number;
}

export interface MeasuredProfile {
  distance_m: number[];
  positions: Vector2[];
  height_m: (number | null)[];
  sigma_m: (number | null)[];
}

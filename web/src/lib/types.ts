// SPDX-License-Identifier: Apache-2.0
// What the server answers (docs/manual/serve.md). Numbers that are not known are null. Pixels: the centre of the upper-left pixel is
// (0.5, 0.5). Map coordinates: [easting, northing, height] in metres, in the CRS of the project.

export type Vector2 = [number, number];
export type Vector3 = [number, number, number];

export interface ProjectName {
  id: string;
  name: string;
  folder: string;
}

export type Severity = "wrong" | "weak" | "note";

export interface Finding {
  code: string;
  severity: Severity;
  /** English sentences. */
  what: string;
  remedy?: string;
  subjects?: { kind: string; name?: string; aspect?: string; axis?: string | number }[];
  figures?: { name: string; value: number | null; unit: string }[];
  remedies?: { code: string; option?: { group: string; field: string; value: string } }[];
}

export interface Step {
  name: string;
  done: boolean;
  /** Done by a version of the program whose record this one cannot read. */
  by_another_version?: boolean;
  seconds?: number | null;
  summary?: string;
  figures?: Record<string, unknown>;
}

export interface ProjectFile {
  path: string;
  bytes: number;
}

export interface Project extends ProjectName {
  images: number;
  cameras: number;
  oriented: number;
  crs: string | null;
  steps: Step[];
  findings: Finding[];
  files: ProjectFile[];
}

export type OptionValue = string | number | boolean | null;
/** Of a group, by the names of its options. */
export type OptionValues = Record<string, OptionValue>;

export interface Choice {
  word: string;
  meaning: string;
}

export interface Option {
  name: string;
  unit: string;
  help: string;
  kind: "flag" | "whole" | "number" | "text" | "path" | "word" | "word_or_text";
  default: OptionValue;
  min?: number;
  max?: number;
  /** What nothing stands for. */
  automatic?: string;
  choices?: Choice[];
  path?: string;
}

export interface OptionGroup {
  step: string;
  group: string;
  options: Option[];
}

export interface Settings {
  options: Record<string, OptionValues>;
}

export type JobState = "queued" | "running" | "done" | "failed" | "stopped";

export interface Job {
  id: number;
  project: string;
  name: string;
  step: string;
  state: JobState;
  stage: string;
  /** Of the stage, in [0, 1]. */
  done: number;
  elapsed_s: number;
  /** Of the stage. */
  left_s: number | null;
  error?: string;
  findings?: Finding[];
  /** When the page heard of it, by its own clock. */
  received_ms?: number;
}

export interface LogLine {
  job: number;
  line: string;
}

/** What the WebSocket sends. */
export interface Changes {
  /** Another one: another server, which counts from 0. */
  board: number;
  number: number;
  jobs: Job[];
  log: LogLine[];
  edits?: { project: string; number: number }[];
}

export interface MapInfo {
  crs: string | null;
  crs_name: string | null;
  proj4: string | null;
  unit: string;
  bounds: [number, number, number, number] | null;
}

export interface ImageInfo {
  id: number;
  file: string;
  width: number;
  height: number;
  /** Of its pyramid of tiles; level `levels - 1` is the native size. */
  levels: number;
  camera: number;
  oriented: boolean;
  /** Of the projection centre; before orientation that of GNSS. */
  position: Vector3 | null;
  sigma_m: Vector3 | null;
  /** In the map's axes, from the projection centre through upper left, upper right, lower right, lower left to the depth of one; null: not oriented, or too wide. */
  corner_rays?: Vector3[] | null;
  /** On the ground. */
  footprint: Vector2[] | null;
  marks: number;
}

/** An edit of the cloud, as `collinea edit` takes it: a prism over a part of the map, and what becomes of its points. */
export interface CloudRegion {
  action: "classify" | "cut" | "crop";
  /** What "classify" gives. */
  class: number | null;
  /** Closed by itself, in the map. */
  ring: Vector2[];
  /** null: without end. */
  low_m: number | null;
  high_m: number | null;
}

export interface Cloud {
  /** Path of the cloud in an octree (COPC). */
  file: string | null;
  /** Path of a cloud in another form. */
  other: string | null;
  /** Edits in force, one after the other. */
  regions: CloudRegion[];
}

export interface Images {
  tile_px: number;
  images: ImageInfo[];
}

/** x, y, residual x, residual y, in pixels. */
export type Residual = [number, number, number, number];

/** E, N, H, their standard deviations, covariance of E and N [m2]. */
export type TiePoint = [number, number, number, number, number, number, number | null];

export interface Mark {
  image: number;
  file: string;
  pixel: Vector2;
  sigma_px: number | null;
  residual_px: Vector2 | null;
  /** Normalised residual. */
  w: number | null;
  redundancy: number | null;
  /** Smallest gross error that the test finds. */
  detectable_px: number | null;
}

export interface ControlPoint {
  name: string;
  role: "control" | "check";
  position: (number | null)[];
  /** null: not given. */
  sigma_m: (number | null)[] | null;
  adjusted: Vector3 | null;
  difference_m: (number | null)[] | null;
  difference_sigma_m: (number | null)[] | null;
  marks: Mark[];
}

export interface Control {
  points: ControlPoint[];
  sigma0: number | null;
}

/** A part of a photograph that all work leaves out. */
export interface Mask {
  name: string;
  /** null: of all photographs. */
  image: number | null;
  ring: Vector2[];
}

/** A part of the map that the orthophoto takes from one photograph. */
export interface Patch {
  name: string;
  image: number;
  file: string;
  ring: Vector2[];
}

export interface Work {
  masks: Mask[];
  patches: Patch[];
}

/** The mark that would help all points most. */
export interface NextMark {
  point: string;
  image: number;
  file: string;
  pixel: Vector2;
  /** Points with a position, before and after. */
  placed: [number, number];
  rms_sigma_m: [number, number];
}

export interface Ellipse {
  major_px: number;
  minor_px: number;
  /** Of the major axis from +x towards +y. */
  angle_deg: number;
}

/** Where a control point is expected in a photograph. */
export interface Place {
  image: number;
  file: string;
  pixel: Vector2;
  ellipse: Ellipse | null;
  marked: boolean;
  /** By the surface of the project. */
  hidden: boolean;
  sigma_after_m: number | null;
}

/** A point from its marks in oriented photographs alone, as they are now. */
export interface MarkedPoint {
  position: Vector3;
  sigma_m: Vector3;
  difference_m: (number | null)[];
  difference_sigma_m: (number | null)[];
  sigma0: number | null;
  redundancy: number;
  /** Of column and row. */
  marks: { image: number; residual_px: Vector2; redundancy: (number | null)[]; w: (number | null)[]; detectable_px: (number | null)[] }[];
}

export interface Places {
  /** The one that helps most first, those that are marked last. */
  places: Place[];
  /** The given coordinates contradict the marks, and were not used. */
  given_disagrees?: boolean;
  /** Photographs whose marks contradict the others, and were not used. */
  contradicting?: number[];
  marked?: MarkedPoint | null;
  /** The point as the whole block has it with all marks as they are now; differences are residuals of control. */
  in_block?: Omit<MarkedPoint, "redundancy"> | null;
}

export type MarkKind = "auto" | "circle" | "cross" | "chequerboard" | "tag";

export interface Refined {
  pixel: Vector2;
  covariance_px2: Vector3;
  sigma_px: number;
  kind: string;
}

/** A coded tag of a photograph. */
export interface FoundTag {
  family: string;
  number: number;
  pixel: Vector2;
  sigma_px: number;
}

export interface Edit {
  number: number;
  time: string;
  command: string[];
  undone: boolean;
}

export interface Edits {
  number: number;
  undo: string | null;
  redo: string | null;
  entries: Edit[];
}

// SPDX-License-Identifier: Apache-2.0
// Requests to the server, one function each.
import type {
  Cloud, Control, Edits, FoundTag, Images, MapInfo, MarkKind, NextMark, OptionGroup, OptionValues, Places, Project, ProjectName, Refined, Residual, Settings, TiePoint, Vector2,
  Work,
} from "./types";
import type { Ground, StereoMark, StereoPlace } from "./stereo_types";
import type { AskedVertex, Drawing, FigureKind, MeasuredFigure, MeasuredProfile, MeasuredVolume, Vertex } from "./drawing_types";

/** The server said no. */
export class Refused extends Error {
  constructor(
    message: string,
    readonly status: number,
  ) {
    super(message);
  }
}

/** Whether a server has nothing of this kind: one that is older, or a project that is not so far. */
export const isMissing = (error: unknown): boolean => error instanceof Refused && error.status === 404;

export const messageOf = (error: unknown): string => (error instanceof Error ? error.message : String(error));

async function ask<T>(path: string, body?: unknown): Promise<T> {
  const how: RequestInit =
    body === undefined ? {} : { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  const response = await fetch(path, how);
  const answer: unknown = await response.json().catch(() => ({}));
  if (response.ok) return answer as T;
  const error = (answer as { error?: unknown }).error;
  throw new Refused(typeof error === "string" ? error : response.statusText || String(response.status), response.status);
}

const base = (project: string): string => `/api/projects/${encodeURIComponent(project)}`;

export const projects = (): Promise<ProjectName[]> => ask("/api/projects");
export const options = (): Promise<OptionGroup[]> => ask("/api/options");
export const project = (id: string): Promise<Project> => ask(base(id));
export const settings = (id: string): Promise<Settings> => ask(`${base(id)}/settings`);

/** Everything up to a step; only options that change are sent. */
export const run = (id: string, step: string, changes: Record<string, OptionValues> = {}): Promise<{ job: number }> =>
  ask(`${base(id)}/jobs`, { step, options: changes });
export const stop = (job: number): Promise<unknown> => ask(`/api/jobs/${job}/stop`, {});

export const map = (id: string): Promise<MapInfo> => ask(`${base(id)}/map`);
export const images = (id: string): Promise<Images> => ask(`${base(id)}/images`);
export const residuals = (id: string, image: number): Promise<{ points: Residual[] }> => ask(`${base(id)}/images/${image}/residuals`);
export const ties = (id: string, most: number): Promise<{ points: TiePoint[] }> => ask(`${base(id)}/ties?most=${most}`);

/** The cloud that can be read by ranges, else one in another form, and the edits of it. */
export const cloud = (id: string): Promise<Cloud> => ask(`${base(id)}/cloud`);

export const control = (id: string): Promise<Control> => ask(`${base(id)}/control`);
/** With the tests that all marks have as they are now: seconds the first time. */
export const controlNow = (id: string): Promise<Control> => ask(`${base(id)}/control/now`);
export const nextMark = (id: string): Promise<{ next: NextMark | null }> => ask(`${base(id)}/control/next`);
export const work = (id: string): Promise<Work> => ask(`${base(id)}/work`);
export const places = (id: string, point: string): Promise<Places> =>
  ask(`${base(id)}/control/${encodeURIComponent(point)}/places`);
export const refine = (id: string, image: number, pixel: Vector2, kind: MarkKind): Promise<Refined> =>
  ask(`${base(id)}/refine`, { image, pixel, kind });
/** Coded tags of a photograph: a second for 20 million pixels. */
export const tags = (id: string, image: number): Promise<{ tags: FoundTag[] }> => ask(`${base(id)}/images/${image}/tags`);
export const edits = (id: string, since = 0): Promise<Edits> => ask(`${base(id)}/edits?since=${since}`);
/** A command of control and marks, as docs/manual/serve.md lists them. */
export const edit = (id: string, command: string[]): Promise<{ number: number }> => ask(`${base(id)}/edits`, { command });

/** With the pixels at which a photograph shows them where one is named. */
export const vertices = (id: string, asked: AskedVertex[], image?: number): Promise<{ vertices: (Vertex | { error: string })[] }> =>
  ask(`${base(id)}/vertices`, { vertices: asked, ...(image === undefined ? {} : { image }) });
/** Several figures of the same vertices: those that they have, and why not the others. */
export const figures = (id: string, kinds: FigureKind[], asked: AskedVertex[]): Promise<{ figures: (MeasuredFigure | { kind: FigureKind; error: string })[] }> =>
  ask(`${base(id)}/figures`, { figures: kinds, vertices: asked });
export const volume = (id: string, ring: Vector2[], over: "rim" | number): Promise<MeasuredVolume> => ask(`${base(id)}/volume`, { ring, base: over });
export const profile = (id: string, line: Vector2[]): Promise<MeasuredProfile> => ask(`${base(id)}/profile`, { line });
/** All features; with the pixels at which a photograph shows their vertices where one is named. */
export const drawing = (id: string, image?: number): Promise<Drawing> => ask(`${base(id)}/drawing${image === undefined ? "" : `?image=${image}`}`);

/** The best pair for a place of the map, or two photographs, or the place in these. */
export const stereo = (id: string, at?: Vector2, images?: Vector2): Promise<StereoPlace> =>
  ask(`${base(id)}/stereo?${[...(at ? [`at=${at.join(",")}`] : []), ...(images ? [`images=${images.join(",")}`] : [])].join("&")}`);
/** The mark set on the ground by least squares matching. */
export const ground = (id: string, images: Vector2, mark: StereoMark, search_px: number): Promise<Ground> => ask(`${base(id)}/ground`, { images, mark, search_px });

/** The address of a file of a project, for links and readers by range. */
export const fileAddress = (id: string, path: string): string => `${base(id)}/files/${path.split("/").map(encodeURIComponent).join("/")}`;
/** What changes when the file does. */
export async function fileTag(id: string, path: string): Promise<string> {
  const response = await fetch(fileAddress(id, path), { method: "HEAD" });
  if (!response.ok) throw new Refused(response.statusText || String(response.status), response.status);
  return response.headers.get("ETag") ?? "";
}
/** The address of a tile of a photograph, with {z}, {x} and {y} left open. */
export const tileAddress = (id: string, image: number): string => `${base(id)}/images/${image}/tiles/{z}/{x}/{y}.jpg`;

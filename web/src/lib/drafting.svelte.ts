// SPDX-License-Identifier: Apache-2.0
// The figure that is being drawn or measured, shared by Map, Photographs, Stereo and Cloud: a click anywhere adds a vertex.
import * as api from "./api";
import { drawCommand } from "./drawing_commands";
import type { AskedMark, AskedVertex, FeatureKind, Vertex } from "./drawing_types";
import type { Vector3 } from "./types";

/** A vertex as the server answered it, with what was asked. */
export type DraftVertex = Vertex & { asked: AskedVertex };

export type Tool = "none" | "draw" | "measure";

const least: Record<FeatureKind, number> = { point: 1, line: 2, polygon: 3 };

/** The fourth corner of a rectangle about three, in space. */
const fourth = (a: Vertex, b: Vertex, c: Vertex): Vector3 => [
  a.position[0] + c.position[0] - b.position[0], a.position[1] + c.position[1] - b.position[1], a.position[2] + c.position[2] - b.position[2],
];

/** The foot of p on the line through b that is square to the side a-b in plan. */
export function squared(a: Vector3, b: Vector3, p: Vector3): [number, number] {
  const [x, y] = [b[0] - a[0], b[1] - a[1]];
  const size = Math.hypot(x, y);
  if (size === 0) return [p[0], p[1]];
  const along = ((p[0] - b[0]) * -y + (p[1] - b[1]) * x) / size;
  return [b[0] + (along * -y) / size, b[1] + (along * x) / size];
}

/** A vertex that was put elsewhere by construction: as good as it was, and no longer where its marks are. */
const moved = (vertex: DraftVertex, position: Vector3): DraftVertex => ({
  ...vertex, position, source: "typed", marks: [], asked: { at: position, sigma_m: vertex.sigma_m, source: "typed" },
});

class Drafting {
  project = $state("");
  tool = $state<Tool>("none");
  layer = $state("drawing");
  kind = $state<FeatureKind>("line");
  /** Of a code list; empty: none. */
  code = $state("");
  /** Whether clicks near a vertex that is drawn take that one. */
  snap = $state(true);
  /** Whether each side stands square to the one before it, in plan. */
  square = $state(false);
  vertices = $state.raw<DraftVertex[]>([]);
  /** Why the last vertex or feature was refused. */
  error = $state("");
  busy = $state(false);
  #queue: Promise<unknown> = Promise.resolve();

  /** Whether a figure has been begun. */
  get active(): boolean {
    return this.vertices.length > 0;
  }
  /** Whether clicks of a view are vertices. */
  get takes(): boolean {
    return this.tool !== "none";
  }

  begin(project: string, layer: string, kind: FeatureKind): void {
    [this.project, this.layer, this.kind, this.tool] = [project, layer, kind, "draw"];
    this.cancel();
  }

  /** What was asked for before in another project is dropped. */
  of(project: string): void {
    if (this.project === project) return;
    this.project = project;
    this.cancel();
  }

  /** Adds a vertex behind those that were asked for before it; false: there is none, and `error` says why. A point is finished with its first. */
  add(asked: AskedVertex): Promise<boolean> {
    return this.#inTurn(async () => {
      const vertex = await this.#answered(asked);
      if (!vertex) return false;
      const [a, b] = this.vertices.slice(-2);
      const squares = this.square && a && b && !("feature" in asked);
      this.vertices = [...this.vertices, squares ? moved(vertex, [...squared(a.position, b.position, vertex.position), vertex.position[2]]) : vertex];
      if (this.tool === "draw" && this.kind === "point") await this.#save();
      return true;
    });
  }

  /** Marks the last vertex in one more photograph: two and more are intersected. Without one, or where that was no mark, a vertex of its own. */
  mark(one: AskedMark, again: boolean): Promise<boolean> {
    const last = this.vertices.at(-1);
    if (!again || !last || !("marks" in last.asked)) return this.add({ marks: [one] });
    const marks = [...last.asked.marks.filter((mark) => mark.image !== one.image), one];
    return this.#inTurn(async () => {
      const vertex = await this.#answered({ marks });
      if (vertex) this.vertices = [...this.vertices.slice(0, -1), vertex];
      return vertex !== undefined;
    });
  }

  back(): void {
    this.vertices = this.vertices.slice(0, -1);
    this.error = "";
  }

  cancel(): void {
    this.vertices = [];
    this.error = "";
  }

  /** The fourth corner of three, or the way back to the first vertex; a polygon is finished. */
  close(): Promise<string | null> {
    return this.#inTurn(async () => {
      const [a, b, c] = this.vertices;
      if (this.square && this.vertices.length === 3 && a && b && c)
        this.vertices = [...this.vertices, moved(c, fourth(a, b, c))];
      if (this.kind === "line" && a) this.vertices = [...this.vertices, a];
      return await this.#save();
    });
  }

  /** Draws it; its id, or null where it is refused. */
  finish(): Promise<string | null> {
    return this.#inTurn(() => this.#save());
  }

  /** Draws a feature anew, with other vertices. */
  redraw(id: string, layer: string, kind: FeatureKind, vertices: Vertex[]): Promise<boolean> {
    return this.edit(drawCommand(id, layer, kind, vertices));
  }

  async edit(command: string[]): Promise<boolean> {
    try {
      await api.edit(this.project, command);
      this.error = "";
      return true;
    } catch (error) {
      this.error = api.messageOf(error);
      return false;
    }
  }

  /** What the server makes of a vertex; nothing: it refused, and `error` says why. */
  async answered(asked: AskedVertex): Promise<DraftVertex | undefined> {
    return await this.#answered(asked);
  }

  async #save(): Promise<string | null> {
    if (this.tool !== "draw") return null;
    if (this.vertices.length < least[this.kind]) {
      this.error = "few";
      return null;
    }
    const command = drawCommand("*", this.layer, this.kind, this.vertices);
    if (!(await this.edit(command))) return null;
    this.vertices = [];
    const id = (await api.drawing(this.project).catch(() => undefined))?.features.at(-1)?.id ?? null;
    if (id && this.code) await this.edit(["attribute", id, "code", this.code]);
    return id;
  }

  async #answered(asked: AskedVertex): Promise<DraftVertex | undefined> {
    try {
      const [answer] = (await api.vertices(this.project, [asked])).vertices;
      if (!answer || "error" in answer) throw new Error(answer?.error ?? "");
      this.error = "";
      return { ...answer, asked };
    } catch (error) {
      this.error = api.messageOf(error);
      return undefined;
    }
  }

  /** Clicks come faster than answers: each waits for the one before it. */
  #inTurn<T>(work: () => Promise<T>): Promise<T> {
    this.busy = true;
    const next = this.#queue.then(work);
    this.#queue = next.catch(() => {}).finally(() => (this.busy = false));
    return next;
  }
}

export const drafting = new Drafting();

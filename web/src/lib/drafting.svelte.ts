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

/** A step of a figure that waits for its answer. */
interface Turn {
  /** Taken back meanwhile: its answer changes nothing. */
  isDropped: boolean;
}

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
  #queue: Promise<unknown> = Promise.resolve();
  /** What was asked for and is not answered yet, in its order. */
  #turns: Turn[] = [];

  /** Whether a figure has been begun. */
  get active(): boolean {
    return this.vertices.length > 0;
  }
  /** Whether clicks of a view are vertices. */
  get takes(): boolean {
    return this.tool !== "none";
  }

  /** What was asked for before in another project is dropped. */
  of(project: string): void {
    if (this.project === project) return;
    this.project = project;
    this.cancel();
  }

  /** Adds a vertex behind those that were asked for before it; false: there is none, and `error` says why. A point is finished with its first. */
  add(asked: AskedVertex): Promise<boolean> {
    return this.#inTurn(false, (turn) => this.#append(asked, turn));
  }

  /** Marks the last vertex in one more photograph: two and more are intersected. Without one, or where that was no mark, a vertex of its own. */
  mark(one: AskedMark, again: boolean): Promise<boolean> {
    return this.#inTurn(false, async (turn) => {
      const last = this.vertices.at(-1);
      if (!again || !last || !("marks" in last.asked)) return await this.#append({ marks: [one] }, turn);
      const marks = [...last.asked.marks.filter((mark) => mark.image !== one.image), one];
      const vertex = await this.#answered({ marks }, turn);
      if (vertex) this.vertices = [...this.vertices.slice(0, -1), vertex];
      return vertex !== undefined;
    });
  }

  /** Takes back what was asked for last, or the last vertex. */
  back(): void {
    const last = this.#turns.filter((turn) => !turn.isDropped).at(-1);
    if (last) last.isDropped = true;
    else this.vertices = this.vertices.slice(0, -1);
    this.error = "";
  }

  cancel(): void {
    for (const turn of this.#turns) turn.isDropped = true;
    this.vertices = [];
    this.error = "";
  }

  /** The fourth corner of three, or the way back to the first vertex; a polygon is finished. Refused, the figure stays as it was. */
  close(): Promise<string | null> {
    return this.#inTurn(null, async (turn) => {
      const [a, b, c] = this.vertices;
      if (this.tool !== "draw") return null;
      if (!a || !b || !c) {
        this.error = "few";
        return null;
      }
      const corners = this.square && this.vertices.length === 3 ? [...this.vertices, moved(c, fourth(a, b, c))] : this.vertices;
      return await this.#save(turn, this.kind === "line" ? [...corners, a] : corners);
    });
  }

  /** Draws it; its id, or null where it is refused. */
  finish(): Promise<string | null> {
    return this.#inTurn(null, (turn) => this.#save(turn));
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

  async #append(asked: AskedVertex, turn: Turn): Promise<boolean> {
    const vertex = await this.#answered(asked, turn);
    if (!vertex) return false;
    const [a, b] = this.vertices.slice(-2);
    const squares = this.square && a && b && !("feature" in asked);
    this.vertices = [...this.vertices, squares ? moved(vertex, [...squared(a.position, b.position, vertex.position), vertex.position[2]]) : vertex];
    if (this.tool === "draw" && this.kind === "point") await this.#save(turn);
    return true;
  }

  async #save(turn: Turn, vertices = this.vertices): Promise<string | null> {
    if (this.tool !== "draw") return null;
    if (vertices.length < least[this.kind]) {
      this.error = "few";
      return null;
    }
    this.#over(turn); // what is sent cannot be taken back
    const project = this.project;
    const command = drawCommand("*", this.layer, this.kind, vertices, this.code ? { code: this.code } : {});
    if (!(await this.edit(command))) return null;
    this.vertices = [];
    return (await api.drawing(project).catch(() => undefined))?.features.at(-1)?.id ?? null;
  }

  async #answered(asked: AskedVertex, turn?: Turn): Promise<DraftVertex | undefined> {
    try {
      const [answer] = (await api.vertices(this.project, [asked])).vertices;
      if (turn?.isDropped) return undefined;
      if (!answer || "error" in answer) throw new Error(answer?.error ?? "");
      this.error = "";
      return { ...answer, asked };
    } catch (error) {
      if (!turn?.isDropped) this.error = api.messageOf(error);
      return undefined;
    }
  }

  /** Clicks come faster than answers: each waits for the one before it, unless it is taken back meanwhile; then its answer is `none`. */
  #inTurn<T>(none: T, work: (turn: Turn) => Promise<T>): Promise<T> {
    const turn: Turn = { isDropped: false };
    this.#turns.push(turn);
    const next = this.#queue.then(() => (turn.isDropped ? none : work(turn)));
    this.#queue = next.catch(() => {}).finally(() => this.#over(turn));
    return next;
  }

  #over(turn: Turn): void {
    this.#turns = this.#turns.filter((one) => one !== turn);
  }
}

export const drafting = new Drafting();

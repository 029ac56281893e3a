// SPDX-License-Identifier: Apache-2.0
// The state of the stereoplotter: pair, floating mark, what moves, and what the mark does when it moves.
import * as api from "../../lib/api";
import type { AskedVertex } from "../../lib/drawing_types";
import type { StereoMark, StereoPlace } from "../../lib/stereo_types";
import type { Vector2, Vector3 } from "../../lib/types";
import { Geometry, pixelAt } from "./geometry";
import type { Display } from "./shaders";

/** What the height does when the mark moves in plan. */
export type Follow = "height" | "contour" | "surface";

const pointing_px = 0.5;
const rest_ms = 150;

/** Where each project was looked at last. */
const looked = new Map<string, { at: Vector2; images: Vector2 }>();

export class Plotter {
  place = $state.raw<StereoPlace | undefined>();
  geometry = $state.raw<Geometry | undefined>();
  mark = $state.raw<StereoMark>([0, 0, 0]);
  /** In the middle of the view: of the left epipolar image, and the parallax that is none on the screen. */
  view = $state.raw<StereoMark>([0, 0, 0]);
  zoom = $state(1);
  display = $state<Display>("anaglyph");
  swapped = $state(false);
  contrast = $state(1);
  brightness = $state(0);
  /** The mark stands in the middle and the image moves; else the mark moves. */
  markFixed = $state(true);
  follow = $state<Follow>("height");
  interval = $state(1);
  error = $state("");
  /** Why the mark was not set on the ground. */
  refusal = $state("");
  busy = $state(false);
  sigma_m = $state.raw<Vector3 | null>(null);
  /** Of the last match, as long as the mark has not moved. */
  matched = $state.raw<{ sigma_px: number; mark_sigma_px: number; correlation: number } | undefined>();
  #latest = 0;
  #resting: ReturnType<typeof setTimeout> | undefined;
  #following: Promise<unknown> | undefined;

  constructor(readonly project: string) {}

  readonly world = $derived(this.geometry?.positionOf(this.mark));
  readonly position = $derived(this.world && this.geometry ? this.geometry.mapOf(this.world) : undefined);
  /** Where the photographs show the mark; NaN where one does not. */
  readonly pixels = $derived<[Vector2, Vector2] | undefined>(
    this.place && [pixelAt(this.place.left.lattice, this.mark[0], this.mark[1]), pixelAt(this.place.right.lattice, this.mark[0] - this.mark[2], this.mark[1])],
  );
  readonly isInBoth = $derived.by(() => {
    if (!this.place || !this.pixels) return false;
    const inside = (pixel: Vector2, side: { width: number; height: number }): boolean => pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] <= side.width && pixel[1] <= side.height;
    return inside(this.pixels[0], this.place.left) && inside(this.pixels[1], this.place.right);
  });

  async open(at?: Vector2, images?: Vector2): Promise<void> {
    const mine = ++this.#latest;
    this.busy = true;
    try {
      const place = await api.stereo(this.project, at, images);
      if (mine !== this.#latest) return;
      this.place = place;
      this.geometry = new Geometry(place);
      this.error = "";
      this.#set(place.mark);
      this.view = place.mark;
    } catch (error) {
      if (mine === this.#latest) this.error = api.messageOf(error);
    } finally {
      if (mine === this.#latest) this.busy = false;
    }
  }

  /** Goes on where the project was looked at last; false: nowhere yet. */
  async goOn(): Promise<boolean> {
    const last = looked.get(this.project);
    if (last) await this.open(last.at, last.images);
    return last !== undefined;
  }

  /** Another pair at the place of the mark. */
  async choose(images: Vector2): Promise<void> {
    const position = this.position;
    await this.open(position && [position[0], position[1]], images);
    if (position && this.geometry) {
      const mark = this.geometry.markAt(this.geometry.worldOf(position));
      if (mark) this.#set(mark);
    }
  }

  /** The next of the pairs that show the place. */
  async next(by: number): Promise<void> {
    const pairs = this.place?.pairs ?? [];
    const here = pairs.findIndex((one) => one.images.join() === this.place?.images.join());
    const next = pairs[(here + by + pairs.length) % pairs.length];
    if (next) await this.choose(next.images);
  }

  /** In the left epipolar image; the height stays, or follows. */
  moveTo(x: number, y: number): void {
    const height = this.position?.[2];
    const mark = height === undefined ? undefined : this.geometry?.markAtHeight(x, y, height, this.mark[2]);
    this.#set(mark ?? [x, y, this.mark[2]]);
    if (this.follow === "surface") void this.toSurface();
  }
  moveBy(dx: number, dy: number): void {
    this.moveTo(this.mark[0] + dx, this.mark[1] + dy);
  }

  /** Up or down, by pixels of parallax; with a contour held by its interval. */
  lift(pixels: number): void {
    const { geometry, position } = this;
    if (!geometry || !position) return;
    let height = position[2] + pixels * geometry.heightOfPixel(this.mark[2]);
    if (this.follow === "contour") {
      const now = position[2] / this.interval;
      height = this.interval * (pixels > 0 ? Math.floor(now + 1e-6) + 1 : Math.ceil(now - 1e-6) - 1);
    }
    if (this.follow === "surface") this.follow = "height";
    this.toHeight(height);
  }
  toHeight(height: number): void {
    const { geometry, position } = this;
    if (!geometry || !position || !Number.isFinite(height)) return;
    const mark = geometry.markAt(geometry.worldOf([position[0], position[1], height]));
    if (mark) this.#set(mark);
  }
  /** To a place of the map. */
  toMap(position: Vector3): void {
    const mark = this.geometry?.markAt(this.geometry.worldOf(position));
    if (mark) this.#set(mark);
  }

  /** Onto what the photographs show there, by least squares matching. */
  async onGround(): Promise<boolean> {
    if (!this.place || this.busy) return false;
    const asked = this.mark;
    this.busy = true;
    try {
      const found = await api.ground(this.project, this.place.images, asked, 12);
      if (asked !== this.mark) return false;
      this.#set(found.mark, false);
      this.sigma_m = found.sigma_m;
      this.matched = found;
      return true;
    } catch (error) {
      this.refusal = api.messageOf(error);
      return false;
    } finally {
      this.busy = false;
    }
  }

  /** Onto the surface model, where the ray of the left photograph meets it. While an answer is awaited others are not asked for. */
  toSurface(): Promise<unknown> {
    this.#following ??= this.#ask().finally(() => (this.#following = undefined));
    return this.#following;
  }
  async #ask(): Promise<void> {
    for (let asked: StereoMark | undefined; asked !== this.mark && this.place && this.pixels; ) {
      asked = this.mark;
      try {
        const [answer] = (await api.vertices(this.project, [{ marks: [{ image: this.place.left.image, pixel: this.pixels[0] }] }])).vertices;
        if (!answer || "error" in answer) throw new Error(answer?.error ?? "");
        const mark = this.geometry?.markAt(this.geometry.worldOf(answer.position));
        if (asked === this.mark && mark) {
          this.#set([asked[0], asked[1], mark[2]]);
          asked = this.mark;
        }
      } catch (error) {
        this.refusal = api.messageOf(error);
        return;
      }
    }
  }

  /** What a vertex here is asked for by. */
  get vertex(): AskedVertex | undefined {
    if (!this.place || !this.pixels || !this.isInBoth) return undefined;
    const sigma_px = this.matched?.mark_sigma_px ?? pointing_px;
    return { marks: [{ image: this.place.left.image, pixel: this.pixels[0], sigma_px }, { image: this.place.right.image, pixel: this.pixels[1], sigma_px }] };
  }

  /** Of an epipolar image, what is in the middle. */
  middle(which: "left" | "right"): Vector2 {
    return which === "left" ? [this.view[0], this.view[1]] : [this.view[0] - this.view[2], this.view[1]];
  }

  dispose(): void {
    if (this.place && this.position) looked.set(this.project, { at: [this.position[0], this.position[1]], images: this.place.images });
    clearTimeout(this.#resting);
    ++this.#latest;
  }

  #set(mark: StereoMark, asks = true): void {
    this.mark = mark;
    if (this.markFixed) this.view = mark;
    this.matched = undefined;
    this.refusal = "";
    this.sigma_m = null;
    clearTimeout(this.#resting);
    if (asks) this.#resting = setTimeout(() => void this.#askSigma(), rest_ms);
  }

  async #askSigma(): Promise<void> {
    const mark = this.mark;
    const asked = this.vertex;
    if (!asked) return;
    const answer = (await api.vertices(this.project, [asked]).catch(() => undefined))?.vertices[0];
    if (mark === this.mark && answer && !("error" in answer)) this.sigma_m = answer.sigma_m;
  }
}

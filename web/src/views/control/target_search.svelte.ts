// SPDX-License-Identifier: Apache-2.0
// Looks for coded tags in all photographs, and for targets where points are predicted; what it finds is offered, and nothing is marked before it is accepted.
import * as api from "../../lib/api";
import type { Place } from "../../lib/types";
import type { Desk } from "./desk.svelte";
import { type FoundMark, offOf, pointOfTag } from "./found";

export class TargetSearch {
  found = $state.raw<FoundMark[]>([]);
  /** Marks that are to be made. */
  chosen = $state.raw<ReadonlySet<FoundMark>>(new Set());
  /** Photographs and points that were looked at, and all. */
  done = $state(0);
  of = $state(0);
  isRunning = $state(false);
  /** Tags that are no point, counted in every photograph. */
  unknownTags = $state(0);
  error = $state("");
  #run = 0;

  constructor(readonly desk: Desk) {}

  stop(): void {
    ++this.#run;
    this.isRunning = false;
  }

  async start(): Promise<void> {
    const mine = ++this.#run;
    const [images, points] = [this.desk.images.value?.images ?? [], this.desk.points];
    const isOriented = images.some((image) => image.oriented);
    [this.found, this.chosen, this.done, this.of, this.unknownTags, this.error, this.isRunning] = [[], new Set(), 0, images.length + (isOriented ? points.length : 0), 0, "", true];
    /** One after the other: each is the work of a moment for the server, and it has others. */
    const each = async <T>(list: readonly T[], look: (one: T) => Promise<void>): Promise<void> => {
      for (const one of list) {
        if (mine !== this.#run) return;
        await look(one).catch((error: unknown) => mine === this.#run && (this.error = api.messageOf(error)));
        if (mine === this.#run) ++this.done;
      }
    };
    const places = new Map<string, Map<number, Place>>();
    if (isOriented)
      await each(points, async ({ name }) => {
        const held = await api.places(this.desk.project, name);
        places.set(name, new Map(held.places.map((place) => [place.image, place])));
      });
    const names = points.map((one) => one.name);
    await each(images, async (image) => {
      const { tags } = await api.tags(this.desk.project, image.id).catch((error: unknown) => {
        if (api.isMissing(error)) return { tags: [] }; // a server without, or no such photograph
        throw error;
      });
      if (mine !== this.#run) return;
      for (const tag of tags) {
        const point = pointOfTag(names, tag.number);
        if (point === undefined) ++this.unknownTags;
        else this.#offer({ point, image: image.id, file: image.file, pixel: tag.pixel, sigma_px: tag.sigma_px, kind: "tag", ...offOf(tag.pixel, places.get(point)?.get(image.id)) });
      }
      for (const name of names) await this.#target(name, places.get(name)?.get(image.id), mine);
    });
    if (mine === this.#run) this.isRunning = false;
  }

  choose(mark: FoundMark, isWanted: boolean): void {
    this.chosen = new Set(this.found.filter((one) => (one === mark ? isWanted : this.chosen.has(one))));
  }

  /** Marks what is chosen; what is refused stays offered. */
  async accept(): Promise<void> {
    const wanted = this.found.filter((one) => this.chosen.has(one));
    for (const [i, one] of wanted.entries()) {
      const numbers = [...one.pixel, one.sigma_px].map((value) => String(Number(value.toFixed(4))));
      if (!(await this.desk.edit(["mark", one.point, one.file, ...numbers], i === wanted.length - 1))) continue;
      this.found = this.found.filter((other) => other !== one);
      this.choose(one, false);
    }
    await this.desk.reload();
  }

  /** The target where a point is predicted and seen, and neither marked nor offered. */
  async #target(point: string, place: Place | undefined, mine: number): Promise<void> {
    if (!place || place.marked || place.hidden || mine !== this.#run || this.found.some((one) => one.point === point && one.image === place.image)) return;
    try {
      const { pixel, sigma_px, kind } = await api.refine(this.desk.project, place.image, place.pixel, "auto");
      if (mine === this.#run) this.#offer({ point, image: place.image, file: place.file, pixel, sigma_px, kind, ...offOf(pixel, place) });
    } catch (error) {
      if (!(error instanceof api.Refused && error.status === 422)) throw error; // none is there
    }
  }

  /** One of a point in a photograph: the first. */
  #offer(mark: FoundMark): void {
    if (this.found.some((one) => one.point === mark.point && one.image === mark.image)) return;
    if (this.desk.points.find((one) => one.name === mark.point)?.marks.some((one) => one.image === mark.image)) return;
    this.found = [...this.found, mark];
    if (!mark.isFar) this.chosen = new Set([...this.chosen, mark]);
  }
}

// SPDX-License-Identifier: Apache-2.0
// What a person marks: the chosen point and photograph, what is known of them, and edits, which are made one after the other.
import * as api from "../../lib/api";
import { Loaded } from "../../lib/loaded.svelte";
import type { Control, ControlPoint, Edits, ImageInfo, Images, Mark, MarkKind, NextMark, Place, Places, Vector2 } from "../../lib/types";
import { t } from "../../lib/words.svelte";
import { asNow } from "./merge";
import { type Column, nextPlace, nextPoint, type PlaceOrder, placesInOrder, sorted } from "./order";

export interface Note {
  severity: "note" | "wrong";
  text: string;
}

/** The point that was chosen last, by project: other views are looked at meanwhile. */
const lastChosen = new Map<string, string>();

const idleMs = 400;

const exact = (value: number): string => String(Number(value.toFixed(4)));

export class Desk {
  control = new Loaded<Control>();
  images = new Loaded<Images>();
  edits = new Loaded<Edits>();
  places = new Loaded<Places>();
  /** Differences and tests of the whole block with all marks; behind the marks by a moment. */
  now = new Loaded<Control>();
  next = new Loaded<{ next: NextMark | null }>();
  /** Of the chosen point. */
  name = $state("");
  imageId = $state<number | undefined>();
  column = $state<Column>("name");
  isReversed = $state(false);
  placeOrder = $state<PlaceOrder>("best");
  kind = $state<MarkKind>("auto");
  refinesClicks = $state(false);
  note = $state.raw<Note | undefined>();
  /** Edits that are not answered yet. */
  pending = $state(0);
  /** So many marks are enough, and the next point comes; 0: all photographs are marked. */
  enough = $state(6);
  /** Called when another photograph is to be shown, or (`isSame`) when the same is expected elsewhere by now. */
  opened: (isSame: boolean) => void = () => {};
  #actions: Promise<unknown> = Promise.resolve();
  #idle: ReturnType<typeof setTimeout> | undefined;
  #choice = 0; // counts points that were chosen
  #asked = 0; // counts requests for places
  readonly #passed = new Set<number>(); // photographs of the chosen point that were gone by without a mark
  #seen = 0; // number of the last edit that what is shown holds
  #chain: Promise<unknown> = Promise.resolve();

  constructor(readonly project: string) {}

  points = $derived(sorted(asNow(this.control.value, this.now.value), this.column, this.isReversed));
  point = $derived<ControlPoint | undefined>(this.points.find((one) => one.name === this.name));
  /** Where the point is expected; none before orientation. */
  predicted = $derived<Place[]>(this.places.value?.places ?? []);
  /** The photographs to mark it in: those that show it, all where that is not known. */
  listed = $derived<Place[]>(placesInOrder(this.predicted.length ? this.predicted : this.#everywhere(), this.placeOrder));
  place = $derived<Place | undefined>(this.predicted.find((one) => one.image === this.imageId));
  image = $derived<ImageInfo | undefined>(this.images.value?.images.find((one) => one.id === this.imageId));
  mark = $derived<Mark | undefined>(this.point?.marks.find((one) => one.image === this.imageId));
  helpsMost = $derived<Place | undefined>(nextPlace(this.predicted, undefined));

  imageOf(id: number): ImageInfo | undefined {
    return this.images.value?.images.find((one) => one.id === id);
  }

  async start(name: string | undefined): Promise<void> {
    await Promise.all([this.images.load(() => api.images(this.project)), this.reload(false)]);
    const wanted = name ?? lastChosen.get(this.project);
    const first = this.points.find((one) => one.name === wanted) ?? this.points[0];
    if (first) await this.choosePoint(first.name);
  }

  /** Asks for everything that edits and steps change. */
  async reload(hasPlaces = true): Promise<void> {
    const asked: Promise<void>[] = [
      this.control.load(async () => this.#unlessOvertaken(await api.control(this.project), this.control.value)),
      this.#loadEdits(),
    ];
    if (hasPlaces && this.name) asked.push(this.#loadPlaces());
    await Promise.all(asked);
    clearTimeout(this.#idle);
    this.#idle = setTimeout(() => void this.#loadNow(), idleMs);
  }

  /** When the hands rest: the whole block takes a moment, and all points a moment each. */
  async #loadNow(): Promise<void> {
    if (this.pending || !this.images.value?.images.some((image) => image.oriented)) return;
    await this.now.load(() => api.controlNow(this.project));
    if (!this.pending && !this.now.error) await this.next.load(() => api.nextMark(this.project));
  }

  /** Opens the photograph in which a mark would help all points most. */
  async goToNextMark(): Promise<void> {
    const next = this.next.value?.next;
    if (!next) return;
    if (next.point !== this.name) await this.choosePoint(next.point);
    this.chooseImage(next.image);
  }

  /** An edit of this tab or another. */
  async heard(number: number): Promise<void> {
    if (number <= this.#seen || this.pending) return;
    await this.reload();
    if (!this.point) await this.choosePoint(this.points[0]?.name ?? "");
  }

  async choosePoint(name: string): Promise<void> {
    const mine = ++this.#choice;
    if (name) await this.places.load(() => api.places(this.project, name));
    if (mine !== this.#choice) return; // another one was chosen meanwhile
    this.name = name;
    this.#passed.clear();
    if (!name) return;
    lastChosen.set(this.project, name);
    const marked = this.point?.marks[0]?.image;
    this.chooseImage(nextPlace(this.predicted, undefined)?.image ?? marked ?? this.listed[0]?.image);
  }

  chooseImage(id: number | undefined): void {
    this.imageId = id;
    this.opened(false);
  }

  /** The best photograph that is not marked and was not gone by; nothing happens where there is none. */
  nextImage(): boolean {
    if (this.imageId !== undefined && !this.mark) this.#passed.add(this.imageId);
    const places = this.predicted.length ? this.predicted : this.listed;
    if (places.every((place) => place.marked || this.#passed.has(place.image))) this.#passed.clear();
    const next = nextPlace(places, this.imageId, this.#passed);
    if (next) this.chooseImage(next.image);
    return next !== undefined;
  }

  /** The next photograph while the point has not enough marks, else the next point that has not. */
  async goOn(): Promise<void> {
    const isEnough = (point: ControlPoint): boolean => this.enough > 0 && point.marks.length >= this.enough;
    if (this.point && !isEnough(this.point) && this.nextImage()) return;
    const at = this.points.findIndex((point) => point.name === this.name);
    const next = [...this.points.slice(at + 1), ...this.points.slice(0, Math.max(at, 0))].find((point) => !isEnough(point));
    if (next) await this.choosePoint(next.name);
    else this.#say("control.all_done", {});
  }

  /** Through all photographs of the point, marked ones too. */
  stepImage(by: number): void {
    const list = this.listed;
    const at = list.findIndex((place) => place.image === this.imageId);
    if (list.length) this.chooseImage(list[(at + by + list.length) % list.length]?.image);
  }

  async nextPoint(by = 1): Promise<void> {
    const next = nextPoint(this.points, this.name, by);
    if (next && next.name !== this.name) await this.choosePoint(next.name);
  }

  /** Marks the chosen point where the photograph that is shown was clicked, or measures the target there. */
  clicked(pixel: Vector2): Promise<unknown> {
    return this.refinesClicks ? this.refine(pixel) : this.setMark(pixel);
  }

  /** Without a standard deviation: the server gives its own. */
  setMark(pixel: Vector2): Promise<boolean> {
    return this.#inOrder(async (point, image) => {
      const isMade = await this.#mark(point, image, pixel);
      if (isMade) this.#say("control.marked_at", { point: point.name, x: pixel[0].toFixed(2), y: pixel[1].toFixed(2) });
      return isMade;
    });
  }

  /** The target near a pixel is measured and marked. False: none was found, and nothing is marked. */
  refine(pixel: Vector2): Promise<boolean> {
    return this.#inOrder((point, image) => this.#measure(point, image, pixel));
  }

  unmark(): Promise<boolean> {
    return this.#inOrder(async (point, image) => {
      if (!point.marks.some((mark) => mark.image === image.id)) return false;
      this.#assume(point.name, image.id, undefined);
      const isMade = await this.edit(["unmark", point.name, image.file]);
      if (isMade) this.#say("control.unmarked", { point: point.name, file: image.file });
      return isMade;
    });
  }

  /** One key for one mark: measures the target at the predicted place, marks it and goes on; what is marked already is left as it is. */
  accept(): Promise<void> {
    const done = this.#actions.then(async () => {
      const { place, mark, point, image } = this;
      if (!point || !image) return;
      if (mark || (place && (await this.#measure(point, image, place.pixel)))) await this.goOn();
    });
    this.#actions = done;
    return done;
  }

  /** Behind what was asked for before, about the point and the photograph that are shown now. */
  #inOrder(act: (point: ControlPoint, image: ImageInfo) => Promise<boolean>): Promise<boolean> {
    const { name, image } = this;
    const done = this.#actions.then(async () => {
      const point = this.points.find((one) => one.name === name);
      return point && image ? await act(point, image) : false;
    });
    this.#actions = done;
    return done;
  }

  async #mark(point: ControlPoint, image: ImageInfo, pixel: Vector2, sigma_px?: number): Promise<boolean> {
    this.#assume(point.name, image.id, { image: image.id, file: image.file, pixel, sigma_px: sigma_px ?? null, residual_px: null, w: null, redundancy: null, detectable_px: null });
    return await this.edit(["mark", point.name, image.file, exact(pixel[0]), exact(pixel[1]), ...(sigma_px === undefined ? [] : [exact(sigma_px)])]);
  }

  async #measure(point: ControlPoint, image: ImageInfo, pixel: Vector2): Promise<boolean> {
    try {
      const found = await api.refine(this.project, image.id, pixel, this.kind);
      if (!(await this.#mark(point, image, found.pixel, found.sigma_px))) return false;
      this.#say("control.refined", { point: point.name, file: image.file, kind: t(`control.kind.${kindIn(found.kind)}`), sigma: found.sigma_px.toFixed(3) });
      return true;
    } catch (error) {
      this.note = { severity: "wrong", text: error instanceof api.Refused && error.status === 422 ? t("control.no_target") : api.messageOf(error) };
      return false;
    }
  }

  /** Made behind all earlier ones; what is known of control is asked for again. False: refused. */
  edit(command: string[], isLast = true): Promise<boolean> {
    ++this.pending;
    const made = this.#chain.then(async () => {
      try {
        const { number } = await api.edit(this.project, command);
        this.#seen = Math.max(this.#seen, number);
        this.note = undefined;
        return true;
      } catch (error) {
        this.note = { severity: "wrong", text: api.messageOf(error) };
        return false;
      } finally {
        --this.pending;
        if (isLast && !this.pending) void this.reload();
      }
    });
    this.#chain = made;
    return made;
  }

  undo(): Promise<void> {
    return this.#turnBack("undo", () => this.#say("control.undone", { what: this.edits.value?.redo ?? "" })); // what was undone is what can be made again
  }

  redo(): Promise<void> {
    return this.#turnBack("redo", () => this.#say("control.redone", { what: this.edits.value?.undo ?? "" }));
  }

  /** What comes behind it acts on what it left. */
  #turnBack(word: "undo" | "redo", told: () => void): Promise<void> {
    const done = this.#actions.then(async () => {
      if (!(await this.edit([word], false))) return;
      await this.reload();
      told();
    });
    this.#actions = done;
    return done;
  }

  #say(key: Parameters<typeof t>[0], values: Record<string, string | number>): void {
    this.note = { severity: "note", text: t(key, values) };
  }

  async #loadEdits(): Promise<void> {
    await this.edits.load(async () => {
      const edits = await api.edits(this.project);
      this.#seen = Math.max(this.#seen, edits.number);
      return edits;
    });
  }

  async #loadPlaces(): Promise<void> {
    const { name } = this;
    const choice = this.#choice;
    const mine = ++this.#asked;
    const places = await api.places(this.project, name).catch((error: unknown) => error);
    if (choice !== this.#choice || mine !== this.#asked) return; // newer ones are on their way
    await this.places.load(() => (places instanceof Error ? Promise.reject(places) : Promise.resolve(this.#unlessOvertaken(places as Places, this.places.value))));
    if (this.name === name && this.imageId !== undefined) this.opened(true);
  }

  /** What was asked before an edit that is still on its way does not hold it; it is asked for again behind that. */
  #unlessOvertaken<T>(answer: T, before: T | undefined): T {
    return this.pending ? (before ?? answer) : answer;
  }

  #everywhere(): Place[] {
    const marks = this.point?.marks ?? [];
    return (this.images.value?.images ?? []).map((image) => ({
      image: image.id, file: image.file, pixel: [image.width / 2, image.height / 2], ellipse: null, marked: marks.some((mark) => mark.image === image.id), hidden: false, sigma_after_m: null,
    }));
  }

  /** A mark is shown at once, and not when the server has answered. */
  #assume(name: string, image: number, mark: Mark | undefined): void {
    const control = this.control.value;
    if (control)
      this.control.value = {
        ...control,
        points: control.points.map((point) => (point.name === name ? { ...point, marks: [...point.marks.filter((one) => one.image !== image), ...(mark ? [mark] : [])] } : point)),
      };
    const places = this.name === name ? this.places.value : undefined;
    if (places) this.places.value = { ...places, places: places.places.map((place) => (place.image === image ? { ...place, marked: !!mark } : place)) };
  }
}

const kinds = ["circle", "cross", "chequerboard", "tag"] as const;
const kindIn = (word: string): (typeof kinds)[number] => kinds.find((one) => one === word) ?? "cross";

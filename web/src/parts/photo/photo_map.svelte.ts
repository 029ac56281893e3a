// SPDX-License-Identifier: Apache-2.0
// A photograph by its pyramid of tiles, from all of it to single pixels, and what is drawn over it.
import OlMap from "ol/Map";
import type { FrameState } from "ol/Map";
import type MapBrowserEvent from "ol/MapBrowserEvent";
import View from "ol/View";
import DragPan from "ol/interaction/DragPan";
import MouseWheelZoom from "ol/interaction/MouseWheelZoom";
import PinchZoom from "ol/interaction/PinchZoom";
import PointerInteraction from "ol/interaction/Pointer";
import Layer from "ol/layer/Layer";
import TileLayer from "ol/layer/Tile";
import Projection from "ol/proj/Projection";
import ImageTile from "ol/source/ImageTile";
import Source from "ol/source/Source";
import TileGrid from "ol/tilegrid/TileGrid";
import { apply } from "ol/transform";

import { isInside, pixelOf, resolutionsOf, viewOf } from "../../lib/pixels";
import type { ImageInfo, Residual, Vector2 } from "../../lib/types";
import { paintFigure, paintMark, paintPlace, paintResiduals, paintRing, type ShownFigure, type ShownMark, type ShownPlace, type ShownRing, type ToScreen } from "./paint";
import type { Tiles } from "./tiles";

const mostEnlarged = 64; // pixels of the screen per native one
const grip = 10; // about a mark, in which it is taken hold of [px of the screen]

/** What lies over a photograph. */
export interface Drawn {
  marks: ShownMark[];
  place: ShownPlace | undefined;
  residuals: Residual[];
  rings?: ShownRing[];
  figures?: ShownFigure[];
  /** Of residuals. */
  factor: number;
}

export interface Handlers {
  /** Where was clicked, inside the photograph. */
  click?: (pixel: Vector2, event: MouseEvent) => void;
  /** Where the chosen mark was dragged to. */
  moved?: (pixel: Vector2) => void;
}

class Painted extends Layer<Source> {
  readonly #canvas = document.createElement("canvas");
  paintAll: (context: CanvasRenderingContext2D, toScreen: ToScreen, scale: number) => void = () => {};

  constructor() {
    super({ source: new Source({}), zIndex: 5 });
    this.#canvas.className = "drawn";
  }

  override render(frame: FrameState | null): HTMLElement {
    const context = this.#canvas.getContext("2d");
    if (!frame || !context) return this.#canvas;
    const [width = 0, height = 0] = frame.size;
    [this.#canvas.width, this.#canvas.height] = [width * frame.pixelRatio, height * frame.pixelRatio];
    Object.assign(this.#canvas.style, { width: `${width}px`, height: `${height}px`, position: "absolute", pointerEvents: "none" });
    context.scale(frame.pixelRatio, frame.pixelRatio);
    const toScreen = (pixel: Vector2): Vector2 => apply(frame.coordinateToPixelTransform, viewOf(pixel)) as Vector2;
    this.paintAll(context, toScreen, 1 / frame.viewState.resolution);
    return this.#canvas;
  }
}

export class PhotoMap {
  /** Where the pointer is; nothing: not over the photograph. */
  cursor = $state.raw<Vector2 | undefined>();
  /** Pixels of the screen per native one. */
  scale = $state(1);
  /** Whether a person moved it since the place that it was opened at. */
  touched = false;
  readonly #map: OlMap;
  readonly #tiles: Tiles;
  readonly #painted = new Painted();
  readonly #handlers: Handlers;
  readonly #resized: ResizeObserver;
  #layer: TileLayer<ImageTile> | undefined;
  #image: ImageInfo | undefined;
  #drawn: Drawn = { marks: [], place: undefined, residuals: [], factor: 1 };
  #dragged: Vector2 | undefined;
  #pointer: number[] | undefined; // of the screen

  constructor(target: HTMLElement, tiles: Tiles, handlers: Handlers) {
    this.#tiles = tiles;
    this.#handlers = handlers;
    this.#map = new OlMap({
      target,
      controls: [],
      interactions: [new DragPan(), new MouseWheelZoom({ maxDelta: 1 }), new PinchZoom(), this.#dragging()],
      layers: [this.#painted],
    });
    this.#painted.paintAll = (context, toScreen, scale) => this.#paint(context, toScreen, scale);
    this.#map.on("pointermove", (event) => {
      this.#pointer = event.pixel;
      this.#follow();
    });
    this.#map.on("postrender", () => this.#follow()); // the photograph moves below a pointer that rests
    this.#map.on("pointerdrag", () => (this.touched = true));
    this.#map.on("click", (event) => this.#clicked(event));
    this.#map.getViewport().addEventListener("pointerleave", () => (this.#pointer = this.cursor = undefined));
    this.#map.getViewport().addEventListener("wheel", () => (this.touched = true), { passive: true });
    this.#resized = new ResizeObserver(() => this.#map.updateSize());
    this.#resized.observe(target);
  }

  dispose(): void {
    this.#resized.disconnect();
    this.#map.setTarget(undefined);
    this.#map.dispose();
  }

  get image(): ImageInfo | undefined {
    return this.#image;
  }

  /** Another photograph: all of it, or a place of it, in the size that is shown now unless another is given. */
  show(image: ImageInfo, at?: Vector2, scale?: number): void {
    const before = this.#image ? this.scale : undefined;
    if (this.#image?.id !== image.id) this.#change(image);
    this.touched = false;
    if (at) this.goTo(at, scale ?? before ?? 1);
    else this.fit();
  }

  draw(drawn: Partial<Drawn>): void {
    this.#drawn = { ...this.#drawn, ...drawn };
    this.#painted.changed();
  }

  /** What the table of grey values is applied to. */
  setFilter(filter: string): void {
    this.#filter = filter;
    for (const layer of this.#map.getViewport().querySelectorAll<HTMLElement>(".photograph")) layer.style.filter = filter;
  }
  #filter = "";

  fit(): void {
    const image = this.#image;
    if (image) this.#map.getView().fit([0, -image.height, image.width, 0], { padding: [8, 8, 8, 8] });
  }

  goTo(pixel: Vector2, scale = this.scale): void {
    const view = this.#map.getView();
    view.cancelAnimations();
    view.setCenter(viewOf(pixel));
    view.setResolution(1 / scale);
  }

  /** About the pointer, or the middle where it is elsewhere. */
  zoomTo(scale: number): void {
    const view = this.#map.getView();
    this.touched = true;
    view.adjustResolution(this.scale / Math.min(mostEnlarged, scale), this.cursor ? viewOf(this.cursor) : undefined);
  }

  zoomBy(factor: number): void {
    this.zoomTo(this.scale * factor);
  }

  /** By parts of what is seen. */
  pan(right: number, down: number): void {
    const view = this.#map.getView();
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const [x = 0, y = 0] = view.getCenter() ?? [];
    this.touched = true;
    view.setCenter([x + (right * width) / this.scale, y - (down * height) / this.scale]);
  }

  get centre(): Vector2 {
    return pixelOf(this.#map.getView().getCenter() ?? []);
  }

  /** Where the pointer is in the view, as parts of its size; nothing: elsewhere. */
  get cursorPart(): Vector2 | undefined {
    const [x, y] = this.cursor ? (this.#map.getPixelFromCoordinate(viewOf(this.cursor)) ?? []) : [];
    const [width = 1, height = 1] = this.#map.getSize() ?? [];
    return x === undefined || y === undefined ? undefined : [x / width, y / height];
  }

  #inside(pixel: Vector2): Vector2 | undefined {
    return this.#image && isInside(this.#image, pixel) ? pixel : undefined;
  }

  #follow(): void {
    if (!this.#pointer || this.#dragged) return;
    const at = this.#map.getCoordinateFromPixel(this.#pointer) as number[] | null;
    const now = at ? this.#inside(pixelOf(at)) : undefined;
    if (now?.[0] !== this.cursor?.[0] || now?.[1] !== this.cursor?.[1]) this.cursor = now;
  }

  #change(image: ImageInfo): void {
    this.#image = image;
    if (this.#layer) this.#map.removeLayer(this.#layer);
    const extent = [0, -image.height, image.width, 0];
    const projection = new Projection({ code: "photograph", units: "pixels", extent });
    const resolutions = resolutionsOf(image.levels);
    const { tile_px } = this.#tiles;
    const source = new ImageTile({
      projection,
      transition: 0,
      tileGrid: new TileGrid({ extent, origin: [0, 0], resolutions, tileSize: tile_px }),
      // Tiles of the rim are smaller, and OpenLayers would stretch them.
      loader: async (z, x, y) => {
        const canvas = document.createElement("canvas");
        canvas.width = canvas.height = tile_px;
        const bitmap = await this.#tiles.tile(image, { z, x, y });
        if (bitmap) canvas.getContext("2d")?.drawImage(bitmap, 0, 0);
        return canvas;
      },
    });
    source.getInterpolate = () => this.scale < 1.5; // enlarged: pixels as they are
    this.#layer = new TileLayer({ source, extent, className: "photograph", zIndex: 0, preload: 1 });
    this.#layer.on("postrender", () => {
      const element = this.#map.getViewport().querySelector<HTMLElement>(".photograph");
      if (element && element.style.filter !== this.#filter) element.style.filter = this.#filter;
    });
    this.#map.addLayer(this.#layer);
    const view = new View({
      projection, center: [image.width / 2, -image.height / 2], resolution: (resolutions[0] ?? 1) * 2, enableRotation: false,
      minResolution: 1 / mostEnlarged, maxResolution: (resolutions[0] ?? 1) * 4, extent, constrainOnlyCenter: true, smoothExtentConstraint: false,
    });
    view.on("change:resolution", () => (this.scale = 1 / (view.getResolution() ?? 1)));
    this.#map.setView(view);
    this.scale = 1 / (view.getResolution() ?? 1);
  }

  #paint(context: CanvasRenderingContext2D, toScreen: ToScreen, scale: number): void {
    const { marks, place, residuals, factor, rings, figures } = this.#drawn;
    for (const ring of rings ?? []) paintRing(context, toScreen, ring);
    for (const figure of figures ?? []) paintFigure(context, toScreen, figure);
    if (residuals.length) paintResiduals(context, toScreen, residuals, factor);
    if (place) paintPlace(context, toScreen, place, scale);
    for (const mark of [...marks].sort((a, b) => Number(a.chosen) - Number(b.chosen))) {
      const at = mark.chosen && this.#dragged ? { ...mark, pixel: this.#dragged, residual_px: null } : mark;
      paintMark(context, toScreen, at, factor);
    }
  }

  #clicked(event: MapBrowserEvent): void {
    const pixel = this.#inside(pixelOf(event.coordinate));
    if (pixel) this.#handlers.click?.(pixel, event.originalEvent as MouseEvent);
  }

  #isAtChosen(event: MapBrowserEvent): boolean {
    const mark = this.#drawn.marks.find((one) => one.chosen);
    const [x = NaN, y = NaN] = mark ? this.#map.getPixelFromCoordinate(viewOf(mark.pixel)) : [];
    return Math.hypot(x - (event.pixel[0] ?? NaN), y - (event.pixel[1] ?? NaN)) <= grip;
  }

  /** A mark goes by as much as the pointer does, so that taking hold of it beside its middle does not move it. */
  #dragging(): PointerInteraction {
    let offset: Vector2 = [0, 0];
    return new PointerInteraction({
      handleDownEvent: (event) => {
        const mark = this.#drawn.marks.find((one) => one.chosen);
        if (!mark || !this.#handlers.moved || !this.#isAtChosen(event)) return false;
        const [x, y] = pixelOf(event.coordinate);
        offset = [mark.pixel[0] - x, mark.pixel[1] - y];
        return true;
      },
      handleDragEvent: (event) => {
        const [x, y] = pixelOf(event.coordinate);
        this.#dragged = this.#inside([x + offset[0], y + offset[1]]) ?? this.#dragged;
        this.cursor = this.#dragged;
        this.#painted.changed();
      },
      handleUpEvent: () => {
        const to = this.#dragged;
        this.#dragged = undefined;
        if (to) this.#handlers.moved?.(to);
        return false;
      },
      stopDown: (handled) => handled,
    });
  }
}

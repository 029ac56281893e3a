// SPDX-License-Identifier: Apache-2.0
// The map of a project: layers, what lies under the cursor, what was clicked. All in the CRS of the project.
import OlMap from "ol/Map";
import View from "ol/View";
import ScaleLine from "ol/control/ScaleLine";
import Zoom from "ol/control/Zoom";
import { type Extent, boundingExtent, createEmpty, extend, isEmpty } from "ol/extent";
import { defaults as interactions } from "ol/interaction/defaults";
import type BaseLayer from "ol/layer/Base";
import { get as projectionNamed } from "ol/proj";
import Projection from "ol/proj/Projection";
import { register } from "ol/proj/proj4";
import proj4 from "proj4";

import * as api from "../../lib/api";
import { drafting } from "../../lib/drafting.svelte";
import { drawing } from "../../lib/drawing.svelte";
import { Outline } from "../../lib/outline.svelte";
import { station } from "../../lib/station.svelte";
import type { ControlPoint, ImageInfo, MapInfo, Patch, Project, Vector2 } from "../../lib/types";
import { roundFactor } from "./geometry";
import { paintedClasses, paintedValues } from "./paint";
import { Raster } from "./raster";
import { Sketch } from "./sketch";
import { rasterLayer } from "./sources";
import { TieLayer } from "./ties";
import { centres, controlPoints, differences, footprints, marker, patchLayers, placeOf } from "./vectors";

export type LayerName = "ortho" | "hillshade" | "sigma" | "sources" | "patches" | "footprints" | "centres" | "ties" | "differences" | "control";
/** From below upwards. */
const order: LayerName[] = ["hillshade", "sigma", "ortho", "sources", "footprints", "patches", "ties", "centres", "differences", "control"];
const rasterPaths: Partial<Record<LayerName, string>> = {
  ortho: "products/ortho.tif",
  hillshade: "products/dsm_hillshade.tif",
  sigma: "products/dsm_sigma.tif",
  sources: "products/ortho_source.tif",
};
const mostTies = 20000;
const wantedDifference = 90; // at most, of the largest difference [px]

/** As a person left the map, also while another view is looked at. */
interface Kept {
  visible: Partial<Record<LayerName, boolean>>;
  opacity: Partial<Record<LayerName, number>>;
  center?: number[] | undefined;
  resolution?: number | undefined;
}
const keptOf = new Map<string, Kept>();

export class ChartLayer {
  visible = $state(false);
  opacity = $state(1);
  state = $state<"open" | "loading" | "ready" | "missing" | "failed">("open");
  /** Why it failed. */
  error = $state("");
  layer: BaseLayer | undefined;
  constructor(
    readonly name: LayerName,
    readonly make: () => Promise<BaseLayer | undefined>,
  ) {}
}

export interface UnderCursor {
  place: Vector2;
  /** Degrees; null: the CRS is not known. */
  longitude: number | null;
  latitude: number | null;
  height_m: number | null;
  sigma_m: number | null;
}

export class Chart {
  layers = $state.raw<ChartLayer[]>([]);
  info = $state.raw<MapInfo | undefined>();
  images = $state.raw<ImageInfo[]>([]);
  control = $state.raw<ControlPoint[]>([]);
  cursor = $state.raw<UnderCursor | undefined>();
  clicked = $state.raw<UnderCursor | undefined>();
  clickedControl = $state.raw<ControlPoint | undefined>();
  /** The photograph that the orthophoto shows where was clicked; empty: none. */
  ledBy = $state("");
  patches = $state.raw<Patch[]>([]);
  /** Whether clicks are corners of a patch. */
  patching = $state(false);
  readonly outline = new Outline();
  tieFactor = $state(1);
  /** 0: not chosen yet. */
  differenceFactor = $state(0);
  sigmaRange = $state<[number, number]>([0, 1]);
  ready = $state(false);
  /** Metres on the ground of a pixel of the screen. */
  resolution = $state(1);
  /** What the server does not offer. */
  missing = $state.raw<("map" | "images" | "control")[]>([]);
  readonly #project: Project;
  readonly #kept: Kept;
  readonly #rasters = new Map<string, Promise<Raster>>();
  readonly #marker = marker();
  readonly #drawn = patchLayers();
  readonly sketch = new Sketch(() => this.patching);
  #map: OlMap | undefined;
  #projection: Projection = new Projection({ code: "collinea-local", units: "m" });
  /** Browsers keep ranges of a file; when it has changed they get all of it instead of the range that they ask for. */
  readonly #version: string;
  #latest = 0;
  #disposed = false;

  constructor(project: Project) {
    this.#version = `${Math.floor(performance.timeOrigin)}.${station.ended.get(project.id) ?? 0}`;
    this.#project = project;
    const kept = keptOf.get(project.id) ?? { visible: {}, opacity: {} };
    keptOf.set(project.id, kept);
    this.#kept = kept;
  }

  /** Asks for everything and shows it. */
  async show(target: HTMLElement): Promise<void> {
    const ortho = rasterPaths.ortho ?? "";
    if (this.#has(ortho) && this.#kept.visible.ortho !== false) this.#raster(ortho).catch(() => {}); // its head comes meanwhile
    void this.loadPatches();
    const [info, images, control] = await Promise.all([
      this.#offered("map", () => api.map(this.#project.id)),
      this.#offered("images", () => api.images(this.#project.id)),
      this.#offered("control", () => api.control(this.#project.id)),
    ]);
    if (this.#disposed) return;
    this.info = info;
    this.images = images?.images ?? [];
    this.control = control?.points ?? [];
    this.#projection = projectionOf(info) ?? this.#projection;
    this.#makeMap(target);
    await this.#fitFirst();
    this.#makeLayers();
    this.ready = true;
  }

  dispose(): void {
    this.#disposed = true;
    const view = this.#map?.getView();
    if (view && this.ready) [this.#kept.center, this.#kept.resolution] = [view.getCenter(), view.getResolution()];
    this.#map?.setTarget(undefined);
    this.#map?.dispose();
  }

  async setVisible(layer: ChartLayer, visible: boolean): Promise<void> {
    layer.visible = visible;
    this.#kept.visible[layer.name] = visible;
    if (visible) await this.#load(layer);
    layer.layer?.setVisible(visible);
  }

  setOpacity(layer: ChartLayer, opacity: number): void {
    layer.opacity = opacity;
    this.#kept.opacity[layer.name] = opacity;
    layer.layer?.setOpacity(opacity);
  }

  async setControl(points: ControlPoint[]): Promise<void> {
    this.control = points;
    for (const name of ["control", "differences"] as const) await this.#reload(name);
  }

  async setDifferenceFactor(factor: number): Promise<void> {
    this.differenceFactor = factor;
    await this.#reload("differences");
  }

  /** Patches of the orthophoto, as they are in force. */
  async loadPatches(): Promise<void> {
    const work = await this.#offered("work", () => api.work(this.#project.id));
    if (this.#disposed || !work) return;
    this.patches = work.patches;
    this.#drawn.patches(this.patches);
  }

  setPatching(patching: boolean): void {
    this.patching = patching;
    if (patching) [drafting.tool, drawing.chosen] = ["none", undefined]; // keys are about the patch
    this.clearOutline();
  }
  clearOutline(): void {
    this.outline.clear();
    this.#drawn.outline([]);
  }
  backOutline(): void {
    this.outline.back();
    this.#drawn.outline(this.outline.points);
  }

  /** Everything in view. */
  async fit(): Promise<void> {
    const extent = await this.#extent();
    if (!isEmpty(extent)) this.#map?.getView().fit(extent, { padding: [30, 30, 50, 30], minResolution: 0.002 });
  }

  /** A vertex under the pointer, or in the middle of the map. */
  vertexHere(): void {
    const place = this.cursor?.place ?? (this.#map?.getView().getCenter() as Vector2 | undefined);
    if (place) this.sketch.click(place, []);
  }

  /** Looks at the middle of the map, as a click there does. */
  async lookAtCentre(): Promise<void> {
    const centre = this.#map?.getView().getCenter();
    if (centre) await this.#click(centre as Vector2, undefined);
  }

  /** Whether a layer shows nothing until one is nearer. */
  isTooFar(layer: ChartLayer): boolean {
    return layer.state === "ready" && this.resolution > (layer.layer?.getMaxResolution() ?? Infinity);
  }

  highlight(image: number | undefined): void {
    const layer = this.layers.find((one) => one.name === "footprints")?.layer as ReturnType<typeof footprints> | undefined;
    layer?.getSource()?.forEachFeature((feature) => feature.set("chosen", feature.get("image") === image));
  }

  async #offered<T>(name: "map" | "images" | "control" | "work", request: () => Promise<T>): Promise<T | undefined> {
    try {
      return await request();
    } catch (error) {
      if (api.isMissing(error)) this.missing = name === "work" ? this.missing : [...this.missing, name];
      else station.complain(error);
      return undefined;
    }
  }

  #makeMap(target: HTMLElement): void {
    this.#map = new OlMap({
      target,
      interactions: interactions({ onFocusOnly: false, altShiftDragRotate: false, pinchRotate: false }),
      controls: [new Zoom(), new ScaleLine({ units: "metric", minWidth: 90 })],
      view: new View({ projection: this.#projection, center: [0, 0], resolution: 1, minResolution: 0.0005, maxResolution: 5000, enableRotation: false }),
    });
    this.#map.addLayer(this.#marker.layer);
    this.#map.addLayer(this.#drawn.outlineLayer);
    this.sketch.attach(this.#map);
    this.#map.on("moveend", () => (this.resolution = this.#map?.getView().getResolution() ?? 1));
    this.#map.on("pointermove", (event) => {
      if (!event.dragging) void this.#under(event.coordinate as Vector2).then((under) => under && (this.cursor = under));
    });
    // Vertices come as fast as a person clicks: two clicks are two vertices, and zoom nothing.
    this.#map.on("click", (event) => {
      if (drafting.takes) this.sketch.click(event.coordinate as Vector2, event.pixel);
      else if (this.patching) this.#corner(event.coordinate as Vector2);
    });
    this.#map.on("dblclick", (event) => {
      if (drafting.takes || this.patching) event.stopPropagation();
    });
    this.#map.on("singleclick", (event) => drafting.takes || this.patching || void this.#click(event.coordinate as Vector2, event.pixel));
    this.#map.getViewport().addEventListener("pointerleave", () => {
      ++this.#latest;
      this.cursor = undefined;
    });
  }

  #makeLayers(): void {
    const makers: Record<LayerName, (() => Promise<BaseLayer | undefined>) | undefined> = {
      ortho: () => this.#rasterLayer("ortho"),
      hillshade: () => this.#rasterLayer("hillshade"),
      sigma: () => this.#sigmaLayer(),
      sources: () => this.#sourceLayer(),
      patches: this.#has(rasterPaths.ortho ?? "") ? async () => this.#drawn.patchLayer : undefined,
      footprints: this.images.some((image) => image.footprint) ? async () => footprints(this.images) : undefined,
      centres: this.images.some((image) => image.position) ? async () => centres(this.images) : undefined,
      ties: () => this.#tieLayer(),
      control: this.control.length ? async () => controlPoints(this.control) : undefined,
      differences: this.control.some((point) => point.difference_m) ? async () => this.#differenceLayer() : undefined,
    };
    for (const [name, path] of Object.entries(rasterPaths)) if (!this.#has(path)) makers[name as LayerName] = undefined;
    if (this.missing.includes("map")) makers.ties = undefined;
    const standard: Partial<Record<LayerName, boolean>> = { ortho: true, hillshade: !makers.ortho, centres: true, patches: true, control: true, differences: true };
    this.layers = order.flatMap((name) => {
      const make = makers[name];
      if (!make) return [];
      const layer = new ChartLayer(name, make);
      layer.opacity = this.#kept.opacity[name] ?? (name === "sigma" ? 0.7 : name === "sources" ? 0.45 : 1);
      void this.setVisible(layer, this.#kept.visible[name] ?? standard[name] ?? false);
      return [layer];
    });
  }

  #has(path: string): boolean {
    return this.#project.files.some((file) => file.path === path);
  }

  async #load(layer: ChartLayer): Promise<void> {
    if (layer.state !== "open" && layer.state !== "failed") return;
    layer.state = "loading";
    try {
      layer.layer = await layer.make();
      layer.state = layer.layer ? "ready" : "missing";
      if (!layer.layer) return;
      layer.layer.setZIndex(order.indexOf(layer.name));
      layer.layer.setOpacity(layer.opacity);
      layer.layer.setVisible(layer.visible);
      this.#map?.addLayer(layer.layer);
    } catch (error) {
      layer.state = api.isMissing(error) ? "missing" : "failed";
      layer.error = api.messageOf(error);
    }
  }

  async #reload(name: LayerName): Promise<void> {
    const layer = this.layers.find((one) => one.name === name);
    if (!layer?.layer) return;
    this.#map?.removeLayer(layer.layer);
    layer.state = "open";
    await this.#load(layer);
  }

  #raster(path: string): Promise<Raster> {
    let raster = this.#rasters.get(path);
    if (!raster) this.#rasters.set(path, (raster = Raster.open(`${api.fileAddress(this.#project.id, path)}?version=${this.#version}`)));
    return raster;
  }

  async #rasterLayer(name: LayerName): Promise<BaseLayer> {
    return rasterLayer(await this.#raster(rasterPaths[name] ?? ""), this.#projection);
  }

  async #sigmaLayer(): Promise<BaseLayer> {
    const figures = this.#project.steps.find((step) => step.name === "surface")?.figures;
    const mean = typeof figures?.mean_sigma_m === "number" && figures.mean_sigma_m > 0 ? figures.mean_sigma_m : 0.1;
    this.sigmaRange = [0, 3 * mean];
    const raster = await this.#raster(rasterPaths.sigma ?? "");
    return rasterLayer(raster, this.#projection, (bands, nodata) => paintedValues(bands[0] ?? [], nodata, 0, 3 * mean));
  }

  async #sourceLayer(): Promise<BaseLayer> {
    const raster = await this.#raster(rasterPaths.sources ?? "");
    return rasterLayer(raster, this.#projection, (bands, nodata) => paintedClasses(bands[0] ?? [], nodata ?? 0));
  }

  async #leaderAt(place: Vector2): Promise<string> {
    const path = rasterPaths.sources ?? "";
    const sources = this.#project.steps.find((step) => step.name === "ortho")?.figures?.sources;
    if (!this.#has(path) || !Array.isArray(sources)) return "";
    const value = await this.#raster(path).then((raster) => raster.at(...place)).catch(() => null);
    return value ? String(sources[value - 1] ?? "") : "";
  }

  async #tieLayer(): Promise<BaseLayer> {
    const { points } = await api.ties(this.#project.id, mostTies);
    const layer = new TieLayer(points);
    layer.told = (factor) => (this.tieFactor = factor);
    return layer;
  }

  #differenceLayer(): BaseLayer {
    if (this.differenceFactor === 0) {
      const largest = Math.max(0, ...this.control.flatMap((point) => (point.difference_m ?? []).map((one) => Math.abs(one ?? 0))));
      const resolution = this.#map?.getView().getResolution() ?? 1;
      this.differenceFactor = roundFactor((wantedDifference * resolution) / largest);
    }
    return differences(this.control, this.differenceFactor);
  }

  async #extent(): Promise<Extent> {
    if (this.info?.bounds) return this.info.bounds;
    const extent = createEmpty();
    for (const image of this.images) if (image.position) extend(extent, boundingExtent([image.position.slice(0, 2), ...(image.footprint ?? [])]));
    for (const name of ["ortho", "hillshade"] as const) {
      const path = rasterPaths[name] ?? "";
      if (this.#has(path)) await this.#raster(path).then((raster) => extend(extent, raster.extent)).catch(() => {});
    }
    return extent;
  }

  async #fitFirst(): Promise<void> {
    const { center, resolution } = this.#kept;
    const view = this.#map?.getView();
    if (center && resolution) {
      view?.setCenter(center);
      view?.setResolution(resolution);
    } else {
      await this.fit();
    }
  }

  /** Nothing when another place was asked for meanwhile. */
  async #under(place: Vector2): Promise<UnderCursor | undefined> {
    const mine = ++this.#latest;
    const [longitude, latitude] = geographic(this.info, place);
    const value = async (path: string): Promise<number | null> => {
      if (!this.#has(path)) return null;
      return await this.#raster(path).then((raster) => raster.at(...place)).catch(() => null);
    };
    const [height_m, sigma_m] = await Promise.all([value("products/dsm.tif"), value("products/dsm_sigma.tif")]);
    return mine === this.#latest ? { place, longitude, latitude, height_m, sigma_m } : undefined;
  }

  #corner(place: Vector2): void {
    this.outline.add(place);
    this.#drawn.outline(this.outline.points);
  }

  async #click(place: Vector2, pixel: number[] | undefined): Promise<void> {
    if (this.patching) return this.#corner(place);
    if (this.sketch.click(place, pixel ?? this.#map?.getPixelFromCoordinate(place) ?? [])) return;
    const at = pixel ?? this.#map?.getPixelFromCoordinate(place) ?? [];
    const near = this.#map?.getFeaturesAtPixel(at, { hitTolerance: 6 }).find((feature) => feature.get("control") !== undefined);
    this.clickedControl = this.control.find((point) => point.name === near?.get("control"));
    const there = (this.clickedControl && placeOf(this.clickedControl)) ?? place;
    this.#marker.put(there);
    [this.clicked, this.ledBy] = await Promise.all([this.#under(there), this.#leaderAt(there)]);
    this.highlight(undefined);
  }
}

function projectionOf(info: MapInfo | undefined): Projection | undefined {
  if (!info?.proj4) return undefined;
  const code = info.crs ?? "collinea-project";
  try {
    proj4.defs(code, info.proj4);
    register(proj4);
    return projectionNamed(code) ?? undefined;
  } catch {
    return undefined; // a CRS that proj4 does not know: the map stays in its own coordinates
  }
}

function geographic(info: MapInfo | undefined, place: Vector2): [number | null, number | null] {
  if (!info?.proj4) return [null, null];
  try {
    const [longitude = NaN, latitude = NaN] = proj4(info.proj4).inverse(place);
    return Number.isFinite(longitude) && Number.isFinite(latitude) ? [longitude, latitude] : [null, null];
  } catch {
    return [null, null];
  }
}

// SPDX-License-Identifier: Apache-2.0
// What is drawn, on the map: features on their layers, the figure in work, vertices that are moved by dragging.
import type OlMap from "ol/Map";
import Feature from "ol/Feature";
import LineString from "ol/geom/LineString";
import Point from "ol/geom/Point";
import Polygon from "ol/geom/Polygon";
import PointerInteraction from "ol/interaction/Pointer";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { Circle, Fill, Stroke, Style } from "ol/style";

import { drafting } from "../../lib/drafting.svelte";
import { drawing } from "../../lib/drawing.svelte";
import type { FeatureKind, Vertex } from "../../lib/drawing_types";
import { nearestVertex } from "../../lib/snapping";
import type { Vector2 } from "../../lib/types";

const reach = 10; // in which a click means a vertex [px of the screen]
const plan = (vertex: Vertex): Vector2 => [vertex.position[0], vertex.position[1]];

function shape(kind: FeatureKind, places: Vector2[]): Point | LineString | Polygon {
  if (kind === "point" || places.length === 1) return new Point(places[0] ?? [0, 0]);
  if (kind === "line" || places.length === 2) return new LineString(places);
  return new Polygon([[...places, places[0] ?? [0, 0]]]);
}

function styles(colour: string, width: number, dash?: number[]): Style[] {
  return [
    new Style({ stroke: new Stroke({ color: "#ffffff", width: width + 2 }) }),
    new Style({
      stroke: new Stroke({ color: colour, width, ...(dash ? { lineDash: dash } : {}) }),
      fill: new Fill({ color: `${colour}22` }),
      image: new Circle({ radius: 5, fill: new Fill({ color: colour }), stroke: new Stroke({ color: "#ffffff", width: 2 }) }),
    }),
  ];
}
const corner = new Style({ image: new Circle({ radius: 5, fill: new Fill({ color: "#ffd400" }), stroke: new Stroke({ color: "#222222", width: 2 }) }) });

/** A vertex on its way to another place. */
interface Drag {
  feature: string;
  vertex: number;
  /** From the pointer to the vertex. */
  offset: Vector2;
  place: Vector2;
  isMoved: boolean;
}

export class Sketch {
  readonly layer: VectorLayer;
  readonly #source = new VectorSource();
  #map: OlMap | undefined;
  /** Those in the hand and those whose answer is awaited. */
  #drags: Drag[] = [];
  #held: Drag | undefined;
  #moves: Promise<void> = Promise.resolve();

  /** `isBusy`: clicks are about something else, and nothing is dragged. */
  constructor(readonly isBusy: () => boolean) {
    this.layer = new VectorLayer({ source: this.#source, zIndex: 8 });
  }

  attach(map: OlMap): void {
    this.#map = map;
    map.addLayer(this.layer);
    map.addInteraction(this.#dragging());
  }

  /** As drawing and drafting are now. */
  paint(): void {
    this.#source.clear();
    for (const feature of drawing.features) {
      const isChosen = feature.id === drawing.chosen;
      const places = feature.vertices.map(plan);
      for (const drag of this.#drags) if (drag.feature === feature.id && drag.vertex < places.length) places[drag.vertex] = drag.place;
      const made = new Feature({ geometry: shape(feature.kind, places), drawn: feature.id });
      made.setStyle(styles(isChosen ? "#ffd400" : drawing.colourOf(feature.layer), isChosen ? 3 : 2));
      this.#source.addFeature(made);
      if (isChosen) this.#corners(places);
    }
    const draft = drafting.vertices.map(plan);
    if (!draft.length) return;
    const kind = drafting.tool === "measure" && draft.length > 2 ? "polygon" : drafting.kind === "polygon" ? "polygon" : "line";
    const made = new Feature({ geometry: shape(kind, draft) });
    made.setStyle(styles("#ff6d00", 2.5, [6, 4]));
    this.#source.addFeature(made);
    this.#corners(draft);
  }

  /** A click, where clicks are vertices, or on a feature; false: it is about something else. */
  click(place: Vector2, pixel: number[]): boolean {
    if (drafting.takes) {
      const near = drafting.snap ? this.near(place) : undefined;
      void drafting.add(near ?? { surface: place });
      return true;
    }
    const hit = this.#map?.getFeaturesAtPixel(pixel, { hitTolerance: 6, layerFilter: (layer) => layer === this.layer }).find((one) => one.get("drawn"));
    drawing.chosen = hit ? String(hit.get("drawn")) : undefined;
    return hit !== undefined;
  }

  near(place: Vector2): { feature: string; vertex: number } | undefined {
    return nearestVertex(drawing.features, plan, place, reach * (this.#map?.getView().getResolution() ?? 1));
  }

  #corners(places: Vector2[]): void {
    for (const place of places) {
      const made = new Feature(new Point(place));
      made.setStyle(corner);
      this.#source.addFeature(made);
    }
  }

  #dragging(): PointerInteraction {
    return new PointerInteraction({
      handleDownEvent: (event) => {
        const feature = drawing.chosenFeature;
        if (!feature || drafting.takes || this.isBusy()) return false;
        const [x, y] = event.coordinate as Vector2;
        const hit = nearestVertex([feature], plan, [x, y], reach * (event.map.getView().getResolution() ?? 1));
        if (!hit) return false;
        const place = plan(feature.vertices[hit.vertex] as Vertex);
        this.#held = { ...hit, place, offset: [place[0] - x, place[1] - y], isMoved: false };
        return true;
      },
      handleDragEvent: (event) => {
        const drag = this.#held;
        if (!drag) return;
        const [x, y] = event.coordinate as Vector2;
        drag.place = [x + drag.offset[0], y + drag.offset[1]];
        if (!drag.isMoved) this.#drags.push(drag);
        drag.isMoved = true;
        this.paint();
      },
      handleUpEvent: () => {
        const drag = this.#held;
        this.#held = undefined;
        if (drag?.isMoved) this.#moves = this.#moves.then(() => this.#move(drag)); // each on what those before it have made
        return false;
      },
      stopDown: (handled) => handled,
    });
  }

  async #move(drag: Drag): Promise<void> {
    const vertex = await drafting.answered({ surface: drag.place });
    const feature = drawing.features.find((one) => one.id === drag.feature);
    if (feature?.vertices[drag.vertex] && vertex) await drafting.redraw(feature.id, feature.layer, feature.kind, feature.vertices.map((one, index) => (index === drag.vertex ? vertex : one)));
    await drawing.load(drafting.project);
    this.#drags = this.#drags.filter((one) => one !== drag);
    this.paint();
  }
}

// SPDX-License-Identifier: Apache-2.0
// Footprints, projection centres, control and its differences as features of OpenLayers.
import Feature from "ol/Feature";
import LineString from "ol/geom/LineString";
import MultiPoint from "ol/geom/MultiPoint";
import Point from "ol/geom/Point";
import Polygon from "ol/geom/Polygon";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { Circle, Fill, RegularShape, Stroke, Style, Text } from "ol/style";

import type { ControlPoint, ImageInfo, Patch, Vector2 } from "../../lib/types";

// Over photographs of any colour: each has a light rim.
const colours = { footprint: "#1d6fa5", centre: "#0b4f7a", control: "#c2185b", check: "#e07b00", difference: "#d50000", chosen: "#ffd400" };
const rim = new Stroke({ color: "#ffffff", width: 3 });
const labelsBelow = 200; // so many features with names in view can be read

const font = "12px system-ui, sans-serif";
/** Names give way to each other, whatever layer they are of; symbols stay. */
const declutter = "names";
const always = "none" as const;
const named = (text: string): Text => new Text({ text, font, offsetY: -13, fill: new Fill({ color: "#111111" }), stroke: rim, overflow: true });

export function footprints(images: ImageInfo[]): VectorLayer {
  const features = images
    .filter((image) => image.footprint && image.footprint.length > 2)
    .map((image) => new Feature({ geometry: new Polygon([[...(image.footprint as Vector2[]), (image.footprint as Vector2[])[0] as Vector2]]), image: image.id }));
  const plain = new Style({ stroke: new Stroke({ color: colours.footprint, width: 1 }) });
  const chosen = [
    new Style({ stroke: new Stroke({ color: "#222222", width: 4 }), zIndex: 1 }),
    new Style({ stroke: new Stroke({ color: colours.chosen, width: 2 }), fill: new Fill({ color: "rgba(255, 212, 0, 0.12)" }), zIndex: 2 }),
  ];
  return new VectorLayer({ source: new VectorSource({ features }), style: (feature) => (feature.get("chosen") ? chosen : plain) });
}

export function centres(images: ImageInfo[]): VectorLayer {
  const features = images
    .filter((image) => image.position)
    .map((image) => new Feature({ geometry: new Point((image.position as number[]).slice(0, 2)), image: image.id, name: image.file, oriented: image.oriented }));
  const shape = (color: string): RegularShape =>
    new RegularShape({ points: 3, radius: 6, declutterMode: always, fill: new Fill({ color }), stroke: new Stroke({ color: "#ffffff", width: 1.5 }) });
  const shapes = { yes: shape(colours.centre), no: shape("#777777") };
  return new VectorLayer({
    source: new VectorSource({ features }),
    declutter,
    style: (feature) => new Style({ image: feature.get("oriented") ? shapes.yes : shapes.no, ...(features.length < labelsBelow ? { text: named(String(feature.get("name"))) } : {}) }),
  });
}

const at = (point: ControlPoint): Vector2 | null => {
  const [e, n] = point.position;
  if (typeof e === "number" && typeof n === "number") return [e, n];
  return point.adjusted ? [point.adjusted[0], point.adjusted[1]] : null;
};

export const placeOf = at;

export function controlPoints(points: ControlPoint[]): VectorLayer {
  const features = points.flatMap((point) => {
    const place = at(point);
    return place ? [new Feature({ geometry: new Point(place), control: point.name, role: point.role })] : [];
  });
  const white = new Stroke({ color: "#ffffff", width: 2 });
  const shapes = {
    control: new RegularShape({ points: 3, radius: 8, declutterMode: always, fill: new Fill({ color: colours.control }), stroke: white }),
    check: new Circle({ radius: 6, declutterMode: always, fill: new Fill({ color: colours.check }), stroke: white }),
  };
  return new VectorLayer({
    source: new VectorSource({ features }),
    declutter,
    style: (feature) => new Style({ image: feature.get("role") === "check" ? shapes.check : shapes.control, text: named(String(feature.get("control"))), zIndex: 3 }),
  });
}

/** From the surveyed place towards the adjusted one, enlarged; in plan as an arrow, the height as a bar beside it (up: adjusted is higher). */
export function differences(points: ControlPoint[], factor: number): VectorLayer {
  const lines = points.flatMap((point) => {
    const place = at(point);
    const [de = null, dn = null, dh = null] = point.difference_m ?? [];
    if (!place) return [];
    const [e, n] = place;
    const plan = de !== null && dn !== null ? [new Feature({ geometry: new LineString([place, [e + factor * de, n + factor * dn]]), kind: "plan" })] : [];
    const height = dh !== null ? [new Feature({ geometry: new LineString([place, [e, n + factor * dh]]), kind: "height" })] : [];
    return [...height, ...plan];
  });
  const style = (color: string, dash?: number[]): Style[] => [
    new Style({ stroke: new Stroke({ color: "#ffffff", width: 5 }) }),
    new Style({ stroke: new Stroke({ color, width: 2.5, ...(dash ? { lineDash: dash } : {}) }) }),
  ];
  const styles = { plan: style(colours.difference), height: style("#6a1b9a", [4, 3]) };
  return new VectorLayer({ source: new VectorSource({ features: lines }), style: (feature) => (feature.get("kind") === "plan" ? styles.plan : styles.height) });
}

/** Patches of the orthophoto with their photographs, and the outline of one that is being drawn. */
export function patchLayers(): { patchLayer: VectorLayer; outlineLayer: VectorLayer; patches: (all: Patch[]) => void; outline: (points: Vector2[]) => void } {
  const [ofPatches, ofOutline] = [new VectorSource(), new VectorSource()];
  const line = (color: string, width: number, dash?: number[]): Stroke => new Stroke({ color, width, ...(dash ? { lineDash: dash } : {}) });
  const over = (color: string): Style[] => [new Style({ stroke: line("#222222", 4) }), new Style({ stroke: line(color, 2), fill: new Fill({ color: "rgba(255, 255, 255, 0.06)" }) })];
  const corner = new Circle({ radius: 4, fill: new Fill({ color: colours.chosen }), stroke: new Stroke({ color: "#222222", width: 1.5 }) });
  const corners = new Style({ image: corner, geometry: (feature) => new MultiPoint(feature.get("points") as Vector2[]) });
  return {
    patchLayer: new VectorLayer({
      source: ofPatches,
      declutter,
      style: (feature) => [...over("#ff9d3b"), new Style({ text: named(String(feature.get("label"))) })],
    }),
    outlineLayer: new VectorLayer({ source: ofOutline, style: [...over(colours.chosen), corners], zIndex: 9 }),
    patches: (all) => {
      ofPatches.clear();
      ofPatches.addFeatures(all.map((one) => new Feature({ geometry: new Polygon([[...one.ring, one.ring[0] as Vector2]]), label: `${one.name}: ${one.file}` })));
    },
    outline: (points) => {
      ofOutline.clear();
      const [first] = points;
      if (first) ofOutline.addFeature(new Feature({ geometry: new Polygon([[...points, first]]), points }));
    },
  };
}

/** Where was clicked. */
export function marker(): { layer: VectorLayer; put: (place: Vector2 | undefined) => void } {
  const source = new VectorSource();
  const style = [
    new Style({ image: new RegularShape({ points: 4, radius: 11, radius2: 0, stroke: new Stroke({ color: "#ffffff", width: 5 }) }) }),
    new Style({ image: new RegularShape({ points: 4, radius: 11, radius2: 0, stroke: new Stroke({ color: "#111111", width: 2 }) }) }),
  ];
  return {
    layer: new VectorLayer({ source, style, zIndex: 10 }),
    put: (place) => {
      source.clear();
      if (place) source.addFeature(new Feature(new Point(place)));
    },
  };
}

// SPDX-License-Identifier: Apache-2.0
// What lies over the cloud: control points with their names, features that are drawn, the figure in work.
import { BufferAttribute, BufferGeometry, CanvasTexture, Group, Line, LineBasicMaterial, LineLoop, LineSegments, Sprite, SpriteMaterial } from "three";

import type { ControlPoint } from "../../lib/types";
import { sum, type Triple } from "./viewpoint";

const markPixels = 20; // of the texture of a mark: a ring with a dot

function markTexture(colour: string, name: string): { texture: CanvasTexture; width: number; height: number } {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  if (!context) throw new Error("the browser cannot paint");
  const font = "600 26px system-ui, sans-serif";
  context.font = font;
  const [width, height] = [name ? Math.ceil(context.measureText(name).width) + 2 * markPixels + 12 : 2 * markPixels, 2 * markPixels];
  [canvas.width, canvas.height] = [2 * width, height];
  context.font = font;
  context.textBaseline = "middle";
  for (const [style, line] of [["#ffffff", 9], [colour, 5]] as const) {
    [context.strokeStyle, context.lineWidth] = [style, line];
    context.beginPath();
    context.arc(width, height / 2, 11, 0, 2 * Math.PI);
    context.stroke();
  }
  if (name) {
    [context.lineWidth, context.strokeStyle, context.fillStyle] = [6, "#ffffff", "#111111"];
    context.strokeText(name, width + markPixels, height / 2);
    context.fillText(name, width + markPixels, height / 2);
  }
  return { texture: new CanvasTexture(canvas), width: canvas.width, height: canvas.height };
}

export class Overlay {
  readonly group = new Group();
  /** Of a mark: by a pixel of its texture, of the height of the view. */
  #scale = 0.001;

  constructor(readonly order: number) {}

  clear(): void {
    for (const one of [...this.group.children]) {
      this.group.remove(one);
      if (one instanceof Sprite) {
        one.material.map?.dispose();
        one.material.dispose();
      } else if (one instanceof Line || one instanceof LineSegments) {
        one.geometry.dispose();
        (one.material as LineBasicMaterial).dispose();
      }
    }
  }

  mark(place: Triple, colour: string, name = ""): void {
    const { texture, width, height } = markTexture(colour, name);
    const sprite = new Sprite(new SpriteMaterial({ map: texture, sizeAttenuation: false, depthTest: false, depthWrite: false, transparent: true }));
    sprite.position.set(...place);
    sprite.userData["size"] = [width, height];
    sprite.renderOrder = this.order;
    this.group.add(sprite);
    this.resize(this.#scale);
  }

  line(places: Triple[], isClosed: boolean, colour: string): void {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(places.flat()), 3));
    const material = new LineBasicMaterial({ color: colour, depthTest: false, depthWrite: false });
    const line = isClosed ? new LineLoop(geometry, material) : new Line(geometry, material);
    line.renderOrder = this.order;
    line.frustumCulled = false;
    this.group.add(line);
  }

  /** A vertical prism over a ring, between two heights. */
  prism(ring: Triple[], low: number, high: number, colour: string): void {
    for (const height of [low, high]) this.line(ring.map(([x, y]) => [x, y, height]), true, colour);
    for (const [x, y] of ring) this.line([[x, y, low], [x, y, high]], false, colour);
  }

  resize(scale: number): void {
    this.#scale = scale;
    for (const one of this.group.children) {
      const size = one.userData["size"] as [number, number] | undefined;
      if (size) one.scale.set(size[0] * scale, size[1] * scale, 1);
    }
  }
}

export function showControl(overlay: Overlay, points: ControlPoint[], origin: Triple): void {
  overlay.clear();
  for (const point of points) {
    const known = point.position.every((one) => typeof one === "number") ? (point.position as Triple) : undefined;
    const place = point.adjusted ?? known;
    if (place) overlay.mark(sum(place, origin, -1), point.role === "control" ? "#c2185b" : "#e07b00", point.name);
  }
}

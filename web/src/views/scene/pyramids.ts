// SPDX-License-Identifier: Apache-2.0
// The photographs where they were taken: pyramids from the projection centre, with the picture on their base.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, TextureLoader, type Camera, Vector3,
} from "three";

import * as api from "../../lib/api";
import { isInside } from "../../lib/ring";
import type { ImageInfo, Vector2 } from "../../lib/types";
import { sum, type Triple } from "./viewpoint";

/** Pictures that are loaded at once, the largest on the screen; each is a tile of 256 px. */
const mostPictures = 48;
/** Smaller ones show no picture: seen from afar they would hide the cloud below. */
const leastPixels = 160;
const tilePixels = 256;

export interface Pyramid {
  image: ImageInfo;
  /** Local. */
  apex: Triple;
  /** Upper left, upper right, lower right, lower left of the picture; local. */
  corners: [Triple, Triple, Triple, Triple];
}

/** Pyramids of a height, of the images whose rays are known. */
export function pyramidsOf(images: ImageInfo[], origin: Triple, height: number): Pyramid[] {
  return images.flatMap((image) => {
    const rays = image.corner_rays;
    if (!image.oriented || !image.position || !rays || rays.length !== 4) return [];
    const apex = sum(image.position, origin, -1);
    return [{ image, apex, corners: rays.map((ray) => sum(apex, ray, height)) as Pyramid["corners"] }];
  });
}

/** A height that keeps neighbours apart. */
export function pyramidHeight(images: ImageInfo[]): number {
  const places = images.flatMap((image) => (image.position && image.oriented ? [image.position] : []));
  if (places.length < 2) return 5;
  const [low, high] = [0, 1].map((end) => [0, 1, 2].map((axis) => (end ? Math.max : Math.min)(...places.map((one) => one[axis] as number)))) as [Triple, Triple];
  return Math.max((0.5 * Math.hypot(...sum(high, low, -1))) / Math.sqrt(places.length), 0.01);
}

/** The same texture coordinates for every picture: its corners in their order. */
const corners = new Float32Array([0, 1, 1, 1, 1, 0, 0, 0]);

export class Pyramids {
  readonly group = new Group();
  pyramids: Pyramid[] = [];
  readonly #project: string;
  readonly #changed: () => void;
  readonly #loader = new TextureLoader();
  readonly #pictures = new Map<number, Mesh<BufferGeometry, MeshBasicMaterial>>();
  #cover: Mesh<BufferGeometry, MeshBasicMaterial> | undefined;
  #opacity = 0.5;
  readonly #lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0x2f86bd, depthWrite: false }));
  readonly #chosen = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0xffd400, depthTest: false, depthWrite: false }));

  constructor(project: string, changed: () => void) {
    [this.#project, this.#changed] = [project, changed];
    this.#lines.frustumCulled = this.#chosen.frustumCulled = false;
    this.#chosen.renderOrder = 3;
    this.group.add(this.#lines, this.#chosen);
  }

  set(pyramids: Pyramid[]): void {
    this.pyramids = pyramids;
    this.#lines.geometry.setAttribute("position", new BufferAttribute(edges(pyramids), 3));
    for (const id of [...this.#pictures.keys()]) this.#forget(id);
  }

  choose(image: number | undefined): void {
    const chosen = this.pyramids.filter((one) => one.image.id === image);
    this.#chosen.geometry.setAttribute("position", new BufferAttribute(edges(chosen), 3));
    this.#chosen.visible = chosen.length > 0;
  }

  /** Loads the pictures that look largest, and lets go of others. `size`: of a pyramid on the screen [px]; 0: not seen. */
  update(size: (one: Pyramid) => number, hasPictures: boolean): void {
    const seen = hasPictures ? this.pyramids.map((one) => ({ one, size: size(one) })).filter((one) => one.size > leastPixels) : [];
    const wanted = new Map(seen.sort((a, b) => b.size - a.size).slice(0, mostPictures).map(({ one }) => [one.image.id, one]));
    for (const id of [...this.#pictures.keys()]) if (!wanted.has(id)) this.#forget(id);
    for (const [id, one] of wanted) if (!this.#pictures.has(id)) this.#show(one);
  }

  /** Lays the photograph over everything, so many times its pyramid's height away, for who looks from its projection centre; the others are hidden. */
  cover(one: Pyramid | undefined, heights = 1): void {
    this.#lines.visible = !one;
    for (const mesh of this.#pictures.values()) mesh.visible = !one;
    this.#cover?.geometry.dispose();
    this.#cover?.material.map?.dispose();
    this.#cover?.material.dispose();
    if (this.#cover) this.group.remove(this.#cover);
    this.#cover = undefined;
    if (!one) return;
    const mesh = picture({ ...one, corners: one.corners.map((corner) => sum(one.apex, sum(corner, one.apex, -1), heights)) as Pyramid["corners"] });
    [mesh.material.depthTest, mesh.material.depthWrite, mesh.renderOrder, mesh.visible] = [false, false, 2, false];
    this.#cover = mesh;
    this.group.add(mesh);
    void stitched(this.#project, one.image).then((canvas) => {
      if (this.#cover !== mesh) return;
      mesh.material.map = new CanvasTexture(canvas);
      [mesh.material.needsUpdate, mesh.visible] = [true, true];
      this.setOpacity(this.#opacity);
    });
  }

  /** Of the photograph that is looked through. */
  setOpacity(opacity: number): void {
    this.#opacity = opacity;
    if (this.#cover) this.#cover.material.opacity = opacity;
    this.#changed();
  }

  /** The pyramid at a place of the screen. `project` gives pixels, or nothing behind the eye. */
  at(x: number, y: number, camera: Camera, project: (place: Triple) => [number, number] | undefined): Pyramid | undefined {
    let [best, nearest] = [undefined as Pyramid | undefined, Infinity];
    for (const one of this.pyramids) {
      const [apex, ...base] = [one.apex, ...one.corners].map(project);
      if (!apex || base.some((corner) => !corner)) continue;
      const hit = Math.hypot(apex[0] - x, apex[1] - y) < 8 || isInside(base as Vector2[], x, y);
      const away = new Vector3(...one.apex).distanceTo(camera.position);
      if (hit && away < nearest) [best, nearest] = [one, away];
    }
    return best;
  }

  dispose(): void {
    this.cover(undefined);
    for (const id of [...this.#pictures.keys()]) this.#forget(id);
    for (const lines of [this.#lines, this.#chosen]) {
      lines.geometry.dispose();
      lines.material.dispose();
    }
  }

  #show(one: Pyramid): void {
    const mesh = picture(one);
    mesh.material.opacity = 0;
    mesh.visible = !this.#cover;
    this.#pictures.set(one.image.id, mesh);
    this.group.add(mesh);
    const address = api.tileAddress(this.#project, one.image.id).replace("{z}", "0").replace("{x}", "0").replace("{y}", "0");
    this.#loader.load(address, (texture) => {
      if (this.#pictures.get(one.image.id) !== mesh) return texture.dispose();
      mesh.material.map = texture;
      [mesh.material.opacity, mesh.material.transparent, mesh.material.needsUpdate] = [1, false, true];
      this.#changed();
    }, undefined, () => {}); // a photograph that cannot be read stays a pyramid of lines
  }

  #forget(id: number): void {
    const mesh = this.#pictures.get(id);
    if (!mesh) return;
    this.group.remove(mesh);
    mesh.geometry.dispose();
    mesh.material.map?.dispose();
    mesh.material.dispose();
    this.#pictures.delete(id);
  }
}

function picture(one: Pyramid): Mesh<BufferGeometry, MeshBasicMaterial> {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(one.corners.flat()), 3));
  geometry.setAttribute("uv", new BufferAttribute(corners, 2));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ side: DoubleSide, transparent: true }));
  mesh.frustumCulled = false;
  return mesh;
}

/** A photograph from its tiles, about 1000 px wide; tiles that cannot be read stay clear. */
async function stitched(project: string, image: ImageInfo): Promise<HTMLCanvasElement> {
  const z = Math.min(2, image.levels - 1);
  const reduction = 2 ** (image.levels - 1 - z);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.ceil(image.width / reduction), Math.ceil(image.height / reduction)];
  const context = canvas.getContext("2d");
  const tiles = [];
  for (let y = 0; y * tilePixels < canvas.height; ++y)
    for (let x = 0; x * tilePixels < canvas.width; ++x) {
      const tile = new Image();
      tile.src = api.tileAddress(project, image.id).replace("{z}", String(z)).replace("{x}", String(x)).replace("{y}", String(y));
      tiles.push(tile.decode().then(() => context?.drawImage(tile, x * tilePixels, y * tilePixels)).catch(() => {}));
    }
  await Promise.all(tiles);
  return canvas;
}

function edges(pyramids: Pyramid[]): Float32Array {
  return new Float32Array(
    pyramids.flatMap(({ apex, corners }) => corners.flatMap((corner, i) => [...apex, ...corner, ...corner, ...(corners[(i + 1) % 4] as Triple)])),
  );
}

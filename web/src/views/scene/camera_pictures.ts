// SPDX-License-Identifier: Apache-2.0
// Pictures on the pyramids of cameras: those that look largest, loaded as they are needed, as fine as they are seen, within a memory budget.
import { BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, Texture } from "three";

import type { ImageInfo } from "../../lib/types";
import { tilesOfProject } from "../../parts/photo/tiles";
import type { Pyramid } from "./pyramids";

/** Of the GPU's memory, for all pictures [bytes]. */
const memoryBudget = 96e6;
/** Smaller ones show no picture: seen from afar they would hide the cloud below. */
const leastPixels = 160;
const tilePixels = 256;
/** Levels have a side of about 256, 512 and 1024 px: finer ones are for the view of photographs. */
const finestLevel = 2;
const loadsAtOnce = 4;
/** Given to the GPU in one frame, beside the first one [bytes]. */
const bytesPerFrame = 2e6;

/** A picture that a view wants. */
export interface WantedPicture {
  id: number;
  level: number;
  bytes: number;
}

/** How wide and high a level of the image is [px]. */
export function levelSize(image: ImageInfo, level: number): [number, number] {
  const reduction = 2 ** (image.levels - 1 - level);
  return [Math.ceil(image.width / reduction), Math.ceil(image.height / reduction)];
}

/** What a level takes on the GPU, with the reduced ones that are filtered from it. */
const bytesOf = (image: ImageInfo, level: number): number => {
  const [width, height] = levelSize(image, level);
  return Math.ceil((4 / 3) * 4 * width * height);
};

/**
 * The pictures to show of cameras that are seen with a `size` on the screen [px], the largest first: as many as the budget holds at the coarsest
 * level, then finer ones for the largest, as fine as they are seen.
 */
export function wantedPictures(seen: { image: ImageInfo; size: number }[], budget: number): WantedPicture[] {
  const wanted: (WantedPicture & { image: ImageInfo; size: number })[] = [];
  let left = budget;
  for (const { image, size } of seen.filter((one) => one.size > leastPixels).sort((a, b) => b.size - a.size)) {
    const bytes = bytesOf(image, 0);
    if (bytes > left) break;
    left -= bytes;
    wanted.push({ id: image.id, level: 0, bytes, image, size });
  }
  for (const one of wanted)
    while (one.level < Math.min(finestLevel, one.image.levels - 1) && Math.max(...levelSize(one.image, one.level)) < one.size) {
      const bytes = bytesOf(one.image, one.level + 1);
      if (bytes - one.bytes > left) break;
      left -= bytes - one.bytes;
      [one.level, one.bytes] = [one.level + 1, bytes];
    }
  return wanted.map(({ id, level, bytes }) => ({ id, level, bytes }));
}

interface Shown extends WantedPicture {
  mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
}

/** A picture that has come, and waits for its frame. */
interface Come {
  one: Pyramid;
  wanted: WantedPicture;
  bitmap: ImageBitmap;
}

export class CameraPictures {
  readonly group = new Group();
  /** By image, the one used longest ago first. */
  readonly #shown = new Map<number, Shown>();
  readonly #loading = new Map<number, number>(); // image, level
  readonly #failed = new Set<number>();
  #come: Come[] = [];
  #bytes = 0;

  constructor(
    readonly project: string,
    readonly changed: () => void,
  ) {}

  /** `size`: of a pyramid on the screen [px]; 0: not seen. */
  update(pyramids: Pyramid[], size: (one: Pyramid) => number): void {
    const of = new Map(pyramids.map((one) => [one.image.id, one]));
    const wanted = wantedPictures(pyramids.map((one) => ({ image: one.image, size: size(one) })), memoryBudget);
    const isWanted = new Map(wanted.map((one) => [one.id, one]));
    this.#take(isWanted);
    for (const { mesh } of this.#shown.values()) mesh.visible = false;
    for (const one of wanted) {
      const shown = this.#shown.get(one.id);
      if (shown) {
        shown.mesh.visible = true;
        this.#shown.delete(one.id);
        this.#shown.set(one.id, shown);
      }
      const pyramid = of.get(one.id);
      if (pyramid && (shown?.level ?? -1) < one.level) this.#load(pyramid, one);
    }
    this.#evict(isWanted);
  }

  clear(): void {
    for (const id of [...this.#shown.keys()]) this.#forget(id);
    for (const { bitmap } of this.#come) bitmap.close();
    this.#come = [];
    this.#loading.clear();
    this.#failed.clear();
  }

  /** A picture that cannot be read stays a pyramid of lines. */
  #load(pyramid: Pyramid, wanted: WantedPicture): void {
    const { id, level } = wanted;
    if (this.#loading.size >= loadsAtOnce || this.#loading.has(id) || this.#failed.has(id) || this.#come.some((one) => one.wanted.id === id)) return;
    this.#loading.set(id, level);
    void stitched(this.project, pyramid.image, level).then((bitmap) => {
      if (this.#loading.get(id) !== level) return bitmap?.close();
      this.#loading.delete(id);
      if (bitmap) this.#come.push({ one: pyramid, wanted, bitmap });
      else this.#failed.add(id);
      this.changed();
    });
  }

  /** What has come, some of it in each frame: giving it to the GPU takes time. */
  #take(isWanted: Map<number, WantedPicture>): void {
    let given = 0;
    while (this.#come.length && given < bytesPerFrame) {
      const { one, wanted, bitmap } = this.#come.shift() as Come;
      if (!isWanted.has(wanted.id)) {
        bitmap.close();
        continue;
      }
      given += wanted.bytes;
      this.#forget(wanted.id);
      const mesh = pictureMesh(one);
      mesh.material.map = textureOf(bitmap);
      this.#shown.set(wanted.id, { ...wanted, mesh });
      this.#bytes += wanted.bytes;
      this.group.add(mesh);
    }
    if (this.#come.length) this.changed();
  }

  /** Those that are not seen now stay as long as there is memory; then those that are finer than they are seen go as well. */
  #evict(isWanted: Map<number, WantedPicture>): void {
    for (const isDue of [(one: Shown) => !isWanted.has(one.id), (one: Shown) => one.level > (isWanted.get(one.id)?.level ?? 0)])
      for (const one of [...this.#shown.values()]) {
        if (this.#bytes <= memoryBudget) return;
        if (isDue(one)) this.#forget(one.id);
      }
  }

  #forget(id: number): void {
    const shown = this.#shown.get(id);
    if (!shown) return;
    this.group.remove(shown.mesh);
    disposePicture(shown.mesh);
    this.#shown.delete(id);
    this.#bytes -= shown.bytes;
  }
}

/** The same texture coordinates for every picture: its corners in their order. */
const corners = new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]);

/** A quadrilateral for a picture on the base of a pyramid. */
export function pictureMesh(one: Pyramid): Mesh<BufferGeometry, MeshBasicMaterial> {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(one.corners.flat()), 3));
  geometry.setAttribute("uv", new BufferAttribute(corners, 2));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ side: DoubleSide }));
  mesh.frustumCulled = false;
  return mesh;
}

export function disposePicture(mesh: Mesh<BufferGeometry, MeshBasicMaterial>): void {
  mesh.geometry.dispose();
  mesh.material.map?.dispose();
  mesh.material.dispose();
}

/** The bitmap is given back once the GPU has it. */
export function textureOf(bitmap: ImageBitmap): Texture {
  const texture = new Texture(bitmap);
  texture.flipY = false;
  texture.needsUpdate = true;
  texture.onUpdate = () => bitmap.close();
  return texture;
}

/** A photograph at a level from its tiles; tiles that cannot be read stay black, and nothing comes where none can. */
export async function stitched(project: string, image: ImageInfo, level: number): Promise<ImageBitmap | undefined> {
  const [width, height] = levelSize(image, level);
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d", { alpha: false });
  const tiles = tilesOfProject(project, tilePixels);
  const drawn: Promise<boolean>[] = [];
  for (let y = 0; y * tilePixels < height; ++y)
    for (let x = 0; x * tilePixels < width; ++x)
      drawn.push(
        tiles.tile(image, { z: level, x, y }).then((tile) => {
          if (tile) context?.drawImage(tile, x * tilePixels, y * tilePixels);
          return tile !== undefined;
        }),
      );
  return (await Promise.all(drawn)).includes(true) ? canvas.transferToImageBitmap() : undefined;
}

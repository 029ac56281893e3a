// SPDX-License-Identifier: Apache-2.0
// The photographs where they were taken: pyramids from the projection centre, with the picture on their base.
import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments, type Camera, Vector3 } from "three";

import { isInside } from "../../lib/ring";
import type { ImageInfo, Vector2 } from "../../lib/types";
import { CameraPictures, disposePicture, pictureMesh, stitched, textureOf } from "./camera_pictures";
import { sum, type Triple } from "./viewpoint";

/** Of the picture that is looked through, where there is one: about 1000 px wide. */
const coverLevel = 2;

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

export class Pyramids {
  readonly group = new Group();
  pyramids: Pyramid[] = [];
  readonly #project: string;
  readonly #changed: () => void;
  readonly #pictures: CameraPictures;
  #cover: ReturnType<typeof pictureMesh> | undefined;
  #opacity = 0.5;
  readonly #lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0x2f86bd, depthWrite: false }));
  readonly #chosen = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0xffd400, depthTest: false, depthWrite: false }));

  constructor(project: string, changed: () => void) {
    [this.#project, this.#changed] = [project, changed];
    this.#pictures = new CameraPictures(project, changed);
    this.#lines.frustumCulled = this.#chosen.frustumCulled = false;
    this.#chosen.renderOrder = 3;
    this.group.add(this.#lines, this.#chosen, this.#pictures.group);
  }

  set(pyramids: Pyramid[]): void {
    this.pyramids = pyramids;
    this.#lines.geometry.setAttribute("position", new BufferAttribute(edges(pyramids), 3));
    this.#pictures.clear();
  }

  choose(image: number | undefined): void {
    const chosen = this.pyramids.filter((one) => one.image.id === image);
    this.#chosen.geometry.setAttribute("position", new BufferAttribute(edges(chosen), 3));
    this.#chosen.visible = chosen.length > 0;
  }

  /** `size`: of a pyramid on the screen [px]; 0: not seen. */
  update(size: (one: Pyramid) => number, hasPictures: boolean): void {
    this.#pictures.group.visible = hasPictures && !this.#cover;
    if (this.#pictures.group.visible) this.#pictures.update(this.pyramids, size);
  }

  /** Lays the photograph over everything, so many times its pyramid's height away, for who looks from its projection centre; the others are hidden. */
  cover(one: Pyramid | undefined, heights = 1): void {
    this.#lines.visible = !one;
    if (this.#cover) {
      this.group.remove(this.#cover);
      disposePicture(this.#cover);
    }
    this.#cover = undefined;
    if (!one) return;
    const mesh = pictureMesh({ ...one, corners: one.corners.map((corner) => sum(one.apex, sum(corner, one.apex, -1), heights)) as Pyramid["corners"] });
    [mesh.material.transparent, mesh.material.depthTest, mesh.material.depthWrite, mesh.renderOrder, mesh.visible] = [true, false, false, 2, false];
    this.#cover = mesh;
    this.group.add(mesh);
    void stitched(this.#project, one.image, Math.min(coverLevel, one.image.levels - 1)).then((bitmap) => {
      if (this.#cover !== mesh || !bitmap) return bitmap?.close();
      [mesh.material.map, mesh.material.needsUpdate, mesh.visible] = [textureOf(bitmap), true, true];
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
    this.#pictures.clear();
    for (const lines of [this.#lines, this.#chosen]) {
      lines.geometry.dispose();
      lines.material.dispose();
    }
  }
}

function edges(pyramids: Pyramid[]): Float32Array {
  return new Float32Array(
    pyramids.flatMap(({ apex, corners }) => corners.flatMap((corner, i) => [...apex, ...corner, ...corner, ...(corners[(i + 1) % 4] as Triple)])),
  );
}

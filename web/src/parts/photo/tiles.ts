// SPDX-License-Identifier: Apache-2.0
// Tiles of photographs, kept for all that shows them: the large view, small windows and the loupe.
import * as api from "../../lib/api";
import { boundsOf, levelFor, screenOf, tilesOf, type TileIndex, type Window } from "../../lib/pixels";
import type { ImageInfo } from "../../lib/types";

const mostKept = 500; // of 256 x 256 pixels: 130 MB

interface Kept {
  asked: Promise<ImageBitmap | undefined>;
  bitmap?: ImageBitmap | undefined;
}

export class Tiles {
  readonly #kept = new Map<string, Kept>();

  constructor(
    readonly project: string,
    readonly tile_px: number,
  ) {}

  /** Nothing where the server has no such tile. */
  tile(image: ImageInfo, { z, x, y }: TileIndex): Promise<ImageBitmap | undefined> {
    const key = `${image.id}/${z}/${x}/${y}`;
    const found = this.#kept.get(key);
    if (found) {
      this.#kept.delete(key);
      this.#kept.set(key, found);
      return found.asked;
    }
    const kept: Kept = { asked: this.#ask(image, { z, x, y }) };
    this.#kept.set(key, kept);
    void kept.asked.then((bitmap) => {
      kept.bitmap = bitmap;
      if (!bitmap) this.#kept.delete(key); // asked for again when it is wanted again
    });
    this.#forget();
    return kept.asked;
  }

  /** Paints what is here already of a window, and asks for the rest: `again` is called when some of it has come. */
  paint(context: CanvasRenderingContext2D, image: ImageInfo, window: Window, again?: () => void): void {
    const wanted = levelFor(image.levels, window.scale * (globalThis.devicePixelRatio || 1));
    for (let z = 0; z <= wanted; ++z)
      for (const index of tilesOf(image, z, boundsOf(window), this.tile_px)) {
        const bitmap = this.#kept.get(`${image.id}/${z}/${index.x}/${index.y}`)?.bitmap;
        if (bitmap) this.#draw(context, image, window, index, bitmap);
        else if (again && (z === wanted || z === 0)) void this.tile(image, index).then((come) => come && again());
      }
  }

  #draw(context: CanvasRenderingContext2D, image: ImageInfo, window: Window, { z, x, y }: TileIndex, bitmap: ImageBitmap): void {
    const reduction = 2 ** (image.levels - 1 - z);
    const [left, top] = screenOf(window, [x * this.tile_px * reduction, y * this.tile_px * reduction]);
    context.imageSmoothingEnabled = window.scale * reduction < 1.5 || reduction > 1;
    context.drawImage(bitmap, left, top, bitmap.width * reduction * window.scale, bitmap.height * reduction * window.scale);
  }

  async #ask(image: ImageInfo, { z, x, y }: TileIndex): Promise<ImageBitmap | undefined> {
    try {
      const address = api.tileAddress(this.project, image.id).replace("{z}", String(z)).replace("{x}", String(x)).replace("{y}", String(y));
      const response = await fetch(address);
      return response.ok ? await createImageBitmap(await response.blob(), { imageOrientation: "none", colorSpaceConversion: "none" }) : undefined;
    } catch {
      return undefined;
    }
  }

  #forget(): void {
    for (const [key, kept] of this.#kept) {
      if (this.#kept.size <= mostKept) return;
      this.#kept.delete(key);
      void kept.asked.then((bitmap) => bitmap?.close());
    }
  }
}

let latest: Tiles | undefined;

/** Those of the project that is looked at. */
export function tilesOfProject(project: string, tile_px: number): Tiles {
  if (latest?.project !== project || latest.tile_px !== tile_px) latest = new Tiles(project, tile_px);
  return latest;
}

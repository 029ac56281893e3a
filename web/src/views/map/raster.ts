// SPDX-License-Identifier: Apache-2.0
// GeoTIFFs of a project, read by ranges of bytes: a few kilobytes of a file of any size. Not in workers, whose script
// geotiff keeps as text: the content security policy does not allow that.
import { addDecoder, BaseDecoder, fromUrl, type GeoTIFFImage, type TypedArray } from "geotiff";

/** Inflates by the browser, on a thread of its own. */
class BrowserInflate extends BaseDecoder {
  async decodeBlock(bytes: ArrayBuffer): Promise<ArrayBuffer> {
    return await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  }
}
addDecoder([8, 32946], async () => BrowserInflate);

type TypedArrays = TypedArray[];

interface Level {
  image: GeoTIFFImage;
  width: number;
  height: number;
  /** Of a cell on the ground [m]. */
  resolution: number;
  tile: [number, number];
}

const maskFlag = 4; // NewSubfileType: a mask of another image
const mostCells = 16e6; // read at once
const mostKept = 48; // decoded tiles for values under the cursor

export class Raster {
  readonly #kept = new Map<string, Promise<TypedArrays | undefined>>();

  private constructor(
    /** The finest last, as tile grids count. */
    readonly levels: Level[],
    /** West, south, east, north [m]. */
    readonly extent: [number, number, number, number],
    readonly nodata: number | null,
  ) {}

  /** Fails when it is no GeoTIFF, or cannot be read by ranges. */
  static async open(address: string): Promise<Raster> {
    const file = await fromUrl(new URL(address, location.href).href, { blockSize: 65536, cacheSize: 400 });
    const images: GeoTIFFImage[] = [];
    for (let i = 0; i < (await file.getImageCount()); ++i) {
      const image = await file.getImage(i);
      if (!(Number(image.fileDirectory.NewSubfileType ?? 0) & maskFlag)) images.push(image);
    }
    const first = images[0];
    if (!first) throw new Error("no raster in the file");
    const extent = first.getBoundingBox() as [number, number, number, number];
    const levels = images
      .map((image) => ({
        image,
        width: image.getWidth(),
        height: image.getHeight(),
        resolution: (extent[2] - extent[0]) / image.getWidth(),
        tile: [image.getTileWidth(), image.getTileHeight()] as [number, number],
      }))
      .sort((a, b) => a.width - b.width);
    return new Raster(levels, extent, first.getGDALNoData());
  }

  /** Bands of the part of a tile that lies in the raster; nothing where there is none, or nothing is known of the whole tile. */
  async tile(z: number, x: number, y: number, signal?: AbortSignal): Promise<{ bands: TypedArrays; width: number; height: number } | undefined> {
    const level = this.levels[z];
    if (!level) return undefined;
    const [left, top] = [x * level.tile[0], y * level.tile[1]];
    const right = Math.min(left + level.tile[0], level.width);
    const bottom = Math.min(top + level.tile[1], level.height);
    if (left < 0 || top < 0 || left >= right || top >= bottom) return undefined;
    const sizes = level.image.fileDirectory.TileByteCounts as ArrayLike<number> | undefined;
    if (sizes && sizes[y * Math.ceil(level.width / level.tile[0]) + x] === 0) return undefined; // not written
    const bands = await level.image.readRasters({ window: [left, top, right, bottom], ...(signal ? { signal } : {}) });
    return { bands: bands as unknown as TypedArrays, width: right - left, height: bottom - top };
  }

  /** All of it, so large at least where it is that large, by the smallest copy that the file holds; fails where that is too much to read. */
  async reduced(longest_px: number, signal?: AbortSignal): Promise<{ bands: TypedArrays; width: number; height: number }> {
    const level = this.levels.find((one) => Math.max(one.width, one.height) >= longest_px) ?? this.levels.at(-1);
    if (!level || level.width * level.height > mostCells) throw new Error("the file holds no small copy");
    const bands = await level.image.readRasters(signal ? { signal } : {});
    return { bands: bands as unknown as TypedArrays, width: level.width, height: level.height };
  }

  /** The value of the cell at a place, native size; null: outside, or not known. */
  async at(e: number, n: number): Promise<number | null> {
    const z = this.levels.length - 1;
    const level = this.levels[z];
    if (!level) return null;
    const [west, , , north] = this.extent;
    const [column, row] = [Math.floor((e - west) / level.resolution), Math.floor((north - n) / level.resolution)];
    if (column < 0 || row < 0 || column >= level.width || row >= level.height) return null;
    const [x, y] = [Math.floor(column / level.tile[0]), Math.floor(row / level.tile[1])];
    const bands = await this.#keptTile(z, x, y);
    const width = Math.min(level.tile[0], level.width - x * level.tile[0]);
    const value = bands?.[0]?.[(row - y * level.tile[1]) * width + (column - x * level.tile[0])];
    return value === undefined || value === this.nodata || !Number.isFinite(value) ? null : value;
  }

  #keptTile(z: number, x: number, y: number): Promise<TypedArrays | undefined> {
    const key = `${x} ${y}`;
    let tile = this.#kept.get(key);
    if (tile) return tile;
    tile = this.tile(z, x, y).then((read) => read?.bands);
    tile.catch(() => this.#kept.delete(key));
    this.#kept.set(key, tile);
    const oldest = this.#kept.keys().next();
    if (this.#kept.size > mostKept && !oldest.done) this.#kept.delete(oldest.value);
    return tile;
  }
}

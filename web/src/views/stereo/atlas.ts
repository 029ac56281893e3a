// SPDX-License-Identifier: Apache-2.0
// The tiles of one photograph on the GPU: layers of one texture, and a table that says for each tile of the level that is shown in which
// layer it is, or by how much coarser a tile there is for it.
import { Failures } from "../../lib/failures";
import { levelFor, type TileIndex, tilesOf } from "../../lib/pixels";
import type { StereoSide } from "../../lib/stereo_types";
import type { ImageInfo } from "../../lib/types";
import type { Tiles } from "../../parts/photo/tiles";

const tile_px = 256;
const layers = 128;

const keyOf = ({ z, x, y }: TileIndex): string => `${z}/${x}/${y}`;

export class Atlas {
  readonly texture: WebGLTexture;
  readonly pages: WebGLTexture;
  level = 0;
  columns = 1;
  rows = 1;
  readonly #held = new Map<string, number>(); // the one used longest ago first
  readonly #asked = new Set<string>();
  readonly #failures = new Failures<string>(); // of tiles that the server does not have, or not now
  readonly #free = Array.from({ length: layers }, (_, layer) => layer);
  readonly #image: ImageInfo;
  #stale = true;
  #disposed = false;

  constructor(
    readonly gl: WebGL2RenderingContext,
    readonly side: StereoSide,
    readonly tiles: Tiles,
    readonly again: () => void,
  ) {
    this.#image = { id: side.image, file: side.file, width: side.width, height: side.height, levels: side.levels, camera: 0, oriented: true, position: null, sigma_m: null, footprint: null, marks: 0 };
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.RGBA8, tile_px, tile_px, layers);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]] as const)
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, name, value);
    this.pages = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.pages);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
  }

  /** Pixels of the level that is shown for one of the photograph. */
  get reduction(): number {
    return 2 ** (this.level - (this.side.levels - 1));
  }
  get levelSize(): [number, number] {
    return [Math.ceil(this.side.width * this.reduction), Math.ceil(this.side.height * this.reduction)];
  }

  /** What of the photograph (left, top, right, bottom) is shown, `scale` pixels of the screen for one of it: asks for what is missing. */
  show(window: readonly [number, number, number, number], scale: number): void {
    let level = levelFor(this.side.levels, scale);
    let wanted = tilesOf(this.#image, level, window, tile_px);
    while (wanted.length > layers - 8 && level > 0) wanted = tilesOf(this.#image, --level, window, tile_px);
    if (level !== this.level) [this.level, this.#stale] = [level, true];
    const all = [{ z: 0, x: 0, y: 0 }, ...wanted];
    const now = performance.now();
    for (const index of all) {
      const key = keyOf(index);
      const layer = this.#held.get(key);
      if (layer !== undefined) {
        this.#held.delete(key);
        this.#held.set(key, layer);
      } else if (!this.#asked.has(key) && !this.#failures.isOff(key, now)) {
        this.#asked.add(key);
        void this.tiles.tile(this.#image, index).then((bitmap) => this.#come(key, bitmap));
      }
    }
    if (this.#stale) this.#turnPages();
  }

  dispose(): void {
    this.#disposed = true;
    this.gl.deleteTexture(this.texture);
    this.gl.deleteTexture(this.pages);
  }

  /** Whether all that was asked for has come. */
  get complete(): boolean {
    return this.#asked.size === 0;
  }

  #come(key: string, bitmap: ImageBitmap | undefined): void {
    this.#asked.delete(key);
    if (!bitmap) this.#failures.failed(key, performance.now());
    if (this.#disposed || !bitmap) return;
    this.#failures.succeeded(key);
    let layer = this.#free.pop();
    if (layer === undefined) {
      const oldest = [...this.#held.keys()].find((one) => one !== "0/0/0");
      if (oldest === undefined) return;
      layer = this.#held.get(oldest) ?? 0;
      this.#held.delete(oldest);
    }
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, bitmap.width, bitmap.height, 1, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    this.#held.set(key, layer);
    this.#stale = true;
    this.again();
  }

  #turnPages(): void {
    const [width, height] = this.levelSize;
    [this.columns, this.rows] = [Math.ceil(width / tile_px), Math.ceil(height / tile_px)];
    const table = new Uint8Array(2 * this.columns * this.rows);
    for (let y = 0; y < this.rows; ++y)
      for (let x = 0; x < this.columns; ++x)
        for (let down = 0; down <= this.level; ++down) {
          const layer = this.#held.get(`${this.level - down}/${x >> down}/${y >> down}`);
          if (layer === undefined) continue;
          table.set([layer + 1, down], 2 * (y * this.columns + x));
          break;
        }
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D, this.pages);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG8UI, this.columns, this.rows, 0, gl.RG_INTEGER, gl.UNSIGNED_BYTE, table);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    this.#stale = false;
  }
}

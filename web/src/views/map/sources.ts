// SPDX-License-Identifier: Apache-2.0
// Layers of rasters for OpenLayers. Painted on a canvas: its own source of GeoTIFFs wants WebGL, which remote desktops often lack, and workers.
import TileLayer from "ol/layer/Tile";
import type Projection from "ol/proj/Projection";
import ImageTile from "ol/source/ImageTile";
import TileGrid from "ol/tilegrid/TileGrid";

import { type Bands, paintedColours } from "./paint";
import type { Raster } from "./raster";

/** How many cells may become one of the screen where a raster has no smaller copies: beyond, all of it would be read. */
const mostReduction = 4;

/** Bands to four bytes a cell. */
export type Paint = (bands: Bands, nodata: number | null) => Uint8ClampedArray;

function canvasOf(width: number, height: number): { canvas: HTMLCanvasElement; context: CanvasRenderingContext2D } {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  if (!context) throw new Error("the browser cannot paint");
  return { canvas, context };
}

export function rasterLayer(raster: Raster, projection: Projection, paint: Paint = paintedColours): TileLayer<ImageTile> {
  const [west, , , north] = raster.extent;
  const source = new ImageTile({
    projection,
    transition: 0,
    interpolate: false,
    tileGrid: new TileGrid({
      extent: raster.extent,
      origin: [west, north],
      resolutions: raster.levels.map((level) => level.resolution),
      tileSizes: raster.levels.map((level) => level.tile),
    }),
    loader: async (z, x, y, { signal }) => {
      const size = raster.levels[z]?.tile ?? [1, 1];
      const { canvas, context } = canvasOf(...size);
      const tile = await raster.tile(z, x, y, signal);
      if (tile) context.putImageData(new ImageData(new Uint8ClampedArray(paint(tile.bands, raster.nodata)), tile.width, tile.height), 0, 0);
      return canvas;
    },
  });
  const coarsest = raster.levels[0]?.resolution ?? 1;
  const finest = raster.levels.at(-1)?.resolution ?? 1;
  const isSmall = (raster.levels.at(-1)?.width ?? 0) * (raster.levels.at(-1)?.height ?? 0) < 16e6;
  return new TileLayer({
    source,
    extent: raster.extent,
    maxResolution: raster.levels.length > 1 || isSmall ? Infinity : Math.max(coarsest, finest * mostReduction),
  });
}

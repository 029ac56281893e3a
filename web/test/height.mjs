// SPDX-License-Identifier: Apache-2.0
import { readFileSync } from "node:fs";

import { fromArrayBuffer } from "geotiff";

/** The values of a GeoTIFF of one band by their place, read from the file and not by ranges as the page does. */
export async function rasterOf(path) {
  const image = await (await fromArrayBuffer(new Uint8Array(readFileSync(path)).buffer)).getImage(0);
  const [west, south, east, north] = image.getBoundingBox();
  const [width, height] = [image.getWidth(), image.getHeight()];
  const [values] = await image.readRasters();
  return (e, n) => values[Math.floor(((north - n) / (north - south)) * height) * width + Math.floor(((e - west) / (east - west)) * width)];
}

/** The value at one place: of its tile alone, for those that hold nothing are not in the file. */
export async function readValue(path, e, n) {
  const image = await (await fromArrayBuffer(new Uint8Array(readFileSync(path)).buffer)).getImage(0);
  const [west, south, east, north] = image.getBoundingBox();
  const column = Math.floor(((e - west) / (east - west)) * image.getWidth());
  const row = Math.floor(((north - n) / (north - south)) * image.getHeight());
  const [[value]] = await image.readRasters({ window: [column, row, column + 1, row + 1] });
  return value;
}

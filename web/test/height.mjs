// SPDX-License-Identifier: Apache-2.0
import { readFileSync } from "node:fs";

import { fromArrayBuffer } from "geotiff";

/** The value of a GeoTIFF of one band at a place, read as a whole and not by tiles as the page does. */
export async function readValue(path, e, n) {
  const image = await (await fromArrayBuffer(new Uint8Array(readFileSync(path)).buffer)).getImage(0);
  const [west, south, east, north] = image.getBoundingBox();
  const [values] = await image.readRasters();
  const column = Math.floor(((e - west) / (east - west)) * image.getWidth());
  const row = Math.floor(((north - n) / (north - south)) * image.getHeight());
  return values[row * image.getWidth() + column];
}

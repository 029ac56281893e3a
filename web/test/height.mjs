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

/** The value at one place. */
export const readValue = async (path, e, n) => (await rasterOf(path))(e, n);

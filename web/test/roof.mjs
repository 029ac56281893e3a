// SPDX-License-Identifier: Apache-2.0
// A roof of a made-up survey as it truly is, from what `collinea simulate` leaves in truth/: its corners on the map, and where each photograph shows them.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { fromArrayBuffer } from "geotiff";
import { truthOf } from "./truth.mjs";

/** Errors of a person, the same in each run. */
export function normals() {
  let seed = 7;
  const uniform = () => (seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648;
  return () => Math.sqrt(-2 * Math.log(uniform() || 1e-9)) * Math.cos(2 * Math.PI * uniform());
}

async function raster(file) {
  const bytes = readFileSync(file);
  const image = await (await fromArrayBuffer(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength))).getImage();
  const [data] = await image.readRasters();
  const [west, north] = image.getOrigin();
  return { data, width: image.getWidth(), height: image.getHeight(), west, north, cell: image.getResolution()[0] };
}

/** Cells higher than the terrain, part by part. */
function parts(dsm, dtm) {
  const stands = (i) => dsm.data[i] - dtm.data[i] > 1.5;
  const seen = new Uint8Array(dsm.data.length);
  const all = [];
  for (let start = 0; start < seen.length; ++start) {
    if (seen[start] || !stands(start)) continue;
    const part = [start];
    seen[start] = 1;
    for (let next = 0; next < part.length; ++next)
      for (const step of [1, -1, dsm.width, -dsm.width]) {
        const i = part[next] + step;
        if (i < 0 || i >= seen.length || seen[i] || !stands(i)) continue;
        seen[i] = 1;
        part.push(i);
      }
    all.push(part);
  }
  return all;
}

/** The rectangle of least area round cells, and how much of it they fill. */
function rectangle(cells, width) {
  let best;
  for (let degrees = 0; degrees < 90; degrees += 0.5) {
    const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    for (const i of cells) {
      const [x, y] = [i % width, Math.floor(i / width)];
      const [u, v] = [c * x + s * y, c * y - s * x];
      box.splice(0, 4, Math.min(box[0], u), Math.max(box[1], u), Math.min(box[2], v), Math.max(box[3], v));
    }
    const area = (box[1] - box[0] + 1) * (box[3] - box[2] + 1);
    if (!best || area < best.area) best = { c, s, box, area, fill: cells.length / area };
  }
  return best;
}

/** The largest house that is a rectangle: its corner cells with their heights on the roof, and where photographs show them. */
export async function roofOf(survey) {
  const truth = (name) => join(survey, "truth", name);
  const [dsm, dtm] = [await raster(truth("dsm.tif")), await raster(truth("dtm.tif"))];
  const houses = parts(dsm, dtm).map((cells) => ({ cells, box: rectangle(cells, dsm.width) })).filter((one) => one.cells.length > 400 && one.box.fill > 0.93);
  const middle = [dsm.width / 2, dsm.height / 2];
  const away = ({ cells }) => Math.hypot((cells[0] % dsm.width) - middle[0], Math.floor(cells[0] / dsm.width) - middle[1]);
  const { box: { c, s, box }, cells } = houses.sort((one, other) => away(one) - away(other))[0];
  const inside = new Set(cells);
  const corners = [[box[0], box[2]], [box[1], box[2]], [box[1], box[3]], [box[0], box[3]]].map(([u, v]) => {
    const [x, y] = [c * u - s * v, s * u + c * v];
    const distance = (i) => Math.hypot((i % dsm.width) - x, Math.floor(i / dsm.width) - y);
    const cell = [...inside].reduce((best, i) => (distance(i) < distance(best) ? i : best));
    const at = [cell % dsm.width, Math.floor(cell / dsm.width)];
    return [dsm.west + (at[0] + 0.5) * dsm.cell, dsm.north - (at[1] + 0.5) * dsm.cell, dsm.data[cell]];
  });
  const { files, pixel } = truthOf(survey);
  return { corners, pixel, files };
}

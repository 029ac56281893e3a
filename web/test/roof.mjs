// SPDX-License-Identifier: Apache-2.0
// A roof of a made-up survey as it truly is, from what `collinea simulate` leaves in truth/: its corners on the map, and where each photograph shows them.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { fromArrayBuffer } from "geotiff";
import proj4 from "proj4";

const rows = (file) =>
  readFileSync(file, "utf8").split("\n").filter((line) => line.trim() && !line.startsWith("#")).map((line) => line.split(",").map((field) => field.trim()));

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

/** From map to the local frame of the survey: east, north, up at its origin, on the ellipsoid. */
function localFrame(frame) {
  const utm = proj4(`+proj=utm +zone=${Number(frame.crs.slice(-2))} +datum=WGS84 +units=m`);
  const radians = Math.PI / 180;
  const [a, e2] = [6378137, 0.0066943799901413165];
  const ecef = (latitude, longitude, height) => {
    const n = a / Math.sqrt(1 - e2 * Math.sin(latitude) ** 2);
    return [(n + height) * Math.cos(latitude) * Math.cos(longitude), (n + height) * Math.cos(latitude) * Math.sin(longitude), (n * (1 - e2) + height) * Math.sin(latitude)];
  };
  const [lat, lon] = [frame.latitude_deg * radians, frame.longitude_deg * radians];
  const origin = ecef(lat, lon, Number(frame.height_m));
  return ([e, n, h]) => {
    const [longitude, latitude] = utm.inverse([e, n]);
    const [x, y, z] = ecef(latitude * radians, longitude * radians, h).map((value, i) => value - origin[i]);
    return [
      -Math.sin(lon) * x + Math.cos(lon) * y,
      -Math.sin(lat) * Math.cos(lon) * x - Math.sin(lat) * Math.sin(lon) * y + Math.cos(lat) * z,
      Math.cos(lat) * Math.cos(lon) * x + Math.cos(lat) * Math.sin(lon) * y + Math.sin(lat) * z,
    ];
  };
}

function turned([w, x, y, z], [a, b, c]) {
  const [u, v, t] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * u + y * t - z * v, b + w * v + z * u - x * t, c + w * t + x * v - y * u];
}

/** Brown (1971). */
function pixelOf(camera, [x, y, z]) {
  const [u, v] = [x / z, y / z];
  const r2 = u * u + v * v;
  const radial = 1 + r2 * (camera.k1 + r2 * (camera.k2 + r2 * camera.k3));
  const [p1, p2] = [camera.p1, camera.p2];
  const du = u * radial + p1 * (r2 + 2 * u * u) + 2 * p2 * u * v;
  const dv = v * radial + p2 * (r2 + 2 * v * v) + 2 * p1 * u * v;
  return [camera.f * du + camera.cx, camera.f * dv + camera.cy];
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
  const camera = Object.fromEntries(rows(truth("camera.csv")).map(([name, value]) => [name, Number(value)]));
  const local = localFrame(Object.fromEntries(rows(truth("frame.csv"))));
  const poses = Object.fromEntries(rows(truth("poses.csv")).map(([file, ...numbers]) => [file, numbers.map(Number)]));
  const pixel = (file, corner) => {
    const [x, y, z, ...quaternion] = poses[file].slice(0, 7);
    const [a, b, d] = local(corner);
    const [px, py] = pixelOf(camera, turned(quaternion, [a - x, b - y, d - z]));
    return px > 5 && py > 5 && px < camera.width_px - 5 && py < camera.height_px - 5 ? [px, py] : undefined;
  };
  return { corners, pixel, files: Object.keys(poses) };
}

// SPDX-License-Identifier: Apache-2.0
// A made-up survey as it truly is, from what `collinea simulate` leaves in truth/: where its photographs show what lies on the map or in the world.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import proj4 from "proj4";

const rows = (file) =>
  readFileSync(file, "utf8").split("\n").filter((line) => line.trim() && !line.startsWith("#")).map((line) => line.split(",").map((field) => field.trim()));

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

/** `pixel(file, [E, N, H])` and `pixelOfWorld(file, [x, y, z])`: nothing where the photograph does not show it. `marks`: of the survey, by name. */
export function truthOf(survey) {
  const truth = (name) => rows(join(survey, "truth", name));
  const camera = Object.fromEntries(truth("camera.csv").map(([name, value]) => [name, Number(value)]));
  const poses = Object.fromEntries(truth("poses.csv").map(([file, ...numbers]) => [file, numbers.map(Number)]));
  const marks = Object.fromEntries(truth("marks.csv").map(([name, role, ...numbers]) => [name, { role, world: numbers.slice(0, 3).map(Number), map: numbers.slice(3).map(Number) }]));
  const local = localFrame(Object.fromEntries(truth("frame.csv")));
  const pixelOfWorld = (file, [a, b, c]) => {
    const [x, y, z, ...quaternion] = poses[file].slice(0, 7);
    const [px, py] = pixelOf(camera, turned(quaternion, [a - x, b - y, c - z]));
    return px > 5 && py > 5 && px < camera.width_px - 5 && py < camera.height_px - 5 ? [px, py] : undefined;
  };
  return { files: Object.keys(poses), marks, pixelOfWorld, pixel: (file, place) => pixelOfWorld(file, local(place)) };
}

// SPDX-License-Identifier: Apache-2.0
// Answers for what a server does not offer (yet): made of the tables that the adjustment wrote. Where the server answers itself, it is asked.
import { readFileSync } from "node:fs";
import { join } from "node:path";

function table(path) {
  const [head, ...lines] = readFileSync(path, "utf8").trim().split("\n").map((line) => line.split(",").map((field) => field.replaceAll('"', "")));
  return lines.map((line) => Object.fromEntries(head.map((name, at) => [name, Number.isNaN(Number(line[at])) || line[at] === "" ? line[at] : Number(line[at])])));
}

/** @param {string} folder of the project */
export function answersOf(folder) {
  const adjustment = join(folder, "adjustment");
  const poses = table(join(adjustment, "poses.csv"));
  const control = table(join(adjustment, "control.csv"));
  const points = table(join(adjustment, "points.csv"));
  const half = [45, 34]; // of a footprint [m]
  const images = poses.map((pose, at) => ({
    id: at, file: pose.image, width: 640, height: 480, levels: 3, camera: 0, oriented: true, marks: 2,
    position: [pose.x_m, pose.y_m, pose.z_m],
    sigma_m: [pose.sigma_x_m, pose.sigma_y_m, pose.sigma_z_m],
    footprint: [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([e, n]) => [pose.x_m + e * half[0], pose.y_m + n * half[1]]),
  }));
  const [e, n] = ["x_m", "y_m"].map((axis) => poses.map((pose) => pose[axis]));
  return {
    map: {
      crs: "EPSG:32633", crs_name: "WGS 84 / UTM zone 33N", proj4: "+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs", unit: "m",
      bounds: [Math.min(...e) - half[0], Math.min(...n) - half[1], Math.max(...e) + half[0], Math.max(...n) + half[1]],
    },
    images: { tile_px: 256, images },
    control: {
      sigma0: 1,
      points: control.map((one) => ({
        name: one.point, role: one.role,
        position: [one.east_m - one.difference_x_m, one.north_m - one.difference_y_m, one.height_m - one.difference_z_m],
        sigma_m: [0.01, 0.01, 0.015],
        adjusted: [one.east_m, one.north_m, one.height_m],
        difference_m: [one.difference_x_m, one.difference_y_m, one.difference_z_m],
        difference_sigma_m: [one.sigma_x_m, one.sigma_y_m, one.sigma_z_m],
        marks: [],
      })),
    },
    ties: {
      points: points.filter((_, at) => at % 5 === 0).map((one) => [one.east_m, one.north_m, one.height_m, one.sigma_east_m, one.sigma_north_m, one.sigma_height_m, null]),
    },
  };
}

/** Answers in place of the server what it answers with 404. */
export async function standIn(context, base, folder) {
  const projects = await (await context.request.get(`${base}/api/projects`)).json();
  for (const [name, answer] of Object.entries(answersOf(folder))) {
    const own = await context.request.get(`${base}/api/projects/${projects[0].id}/${name}`);
    if (own.status() !== 404) continue;
    await context.route(new RegExp(`/api/projects/[^/]+/${name}(\\?|$)`), (route) => route.fulfill({ json: answer }));
  }
  return projects[0];
}

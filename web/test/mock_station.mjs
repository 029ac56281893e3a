// SPDX-License-Identifier: Apache-2.0
// A browser context in which the page, built before, and all that a server answers of a made-up block come from here: no server, no network.
import { readFileSync } from "node:fs";
import { extname, join } from "node:path";

import { tile, World } from "./mock_world.mjs";

export const base = "http://127.0.0.1:8470";
const policy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'";
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };
const project = { id: "p1", name: "field", folder: "/surveys/field" };

function page(built, path) {
  const name = path === "/" ? "index.html" : path.slice(1);
  try {
    return { body: readFileSync(join(built, name)), contentType: types[extname(name)] ?? "application/octet-stream", headers: { "Content-Security-Policy": policy } };
  } catch {
    return { status: 404, body: "" };
  }
}

function answer(world, request, path) {
  const [what, ...rest] = path;
  const missing = { status: 404, json: { error: "there is nothing here" } };
  if (request.method() === "POST") {
    const body = request.postDataJSON();
    if (what === "edits") return world.edit(body.command);
    const refined = what === "refine" ? world.refine(body) : undefined;
    return refined ? { json: refined } : { status: 422, json: { error: "no target was found within 8 px: mark the point by hand, with its standard deviation" } };
  }
  if (what === undefined) return { json: { ...project, images: 16, cameras: 1, oriented: 15, crs: "EPSG:32633", steps: [], findings: [], files: [] } };
  if (what === "control" && rest[0] === "now") return { json: world.control() };
  if (what === "control" && rest[0] === "next") return { json: { next: null } };
  if (what === "work") return { json: { masks: [], patches: [] } };
  if (what === "drawing") return { json: { layers: [], codes: [], features: [] } };
  if (what === "control" && rest.length) {
    if (!world.isOriented) return { status: 422, json: { error: "the images are not oriented yet: bring the project to the step orient first" } };
    const places = world.places(rest[0]);
    return places ? { json: places } : missing;
  }
  if (what === "images" && rest.length) {
    if (rest[1] === "tags") return { json: world.tags(Number(rest[0])) };
    if (rest[1] === "residuals") return { json: world.residuals(Number(rest[0])) };
    const bytes = tile(Number(rest[0]), Number(rest[2]), Number(rest[3]), parseInt(rest[4], 10));
    return bytes ? { body: bytes, contentType: "image/png", headers: { "Cache-Control": "private, max-age=86400" } } : missing;
  }
  return ["control", "edits", "images", "map"].includes(what) ? { json: world[what]() } : missing;
}

/** @param {string} built folder of the built page */
export async function mockStation(context, built) {
  const world = new World();
  const sockets = new Set();
  world.told = (number) => {
    for (const socket of sockets) socket.send(JSON.stringify({ board: 7, number: 0, jobs: [], log: [], edits: [{ project: project.id, number }] }));
  };
  await context.routeWebSocket(/\/api\/events/, (socket) => {
    sockets.add(socket);
    socket.onClose(() => sockets.delete(socket));
    socket.send(JSON.stringify({ board: 7, number: 0, jobs: [], log: [] }));
  });
  await context.route(`${base}/**`, async (route) => {
    const path = decodeURIComponent(new URL(route.request().url()).pathname);
    const [, api, what, , ...rest] = path.split("/");
    if (api !== "api") return await route.fulfill(page(built, path));
    if (what === "projects" && path.split("/").length > 3) return await route.fulfill(answer(world, route.request(), rest));
    return await route.fulfill({ json: what === "projects" ? [project] : [] });
  });
  return world;
}

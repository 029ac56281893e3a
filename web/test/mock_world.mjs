// SPDX-License-Identifier: Apache-2.0
// A made-up block over flat ground with known truth, its journal of edits, and tiles of its photographs: what the server would answer.
import { deflateSync } from "node:zlib";

const [width, height, levels, tilePx, gsd] = [1600, 1200, 4, 256, 0.05];
const [east, north] = [500_000, 5_300_000];

/** Numbers in [-1, 1] that look like chance, of any words. */
function chance(...words) {
  let hash = 2166136261;
  for (const char of words.join("/")) hash = Math.imul(hash ^ char.charCodeAt(0), 16777619);
  hash ^= hash >>> 15;
  hash = Math.imul(hash, 0x2c1b3c6d);
  hash ^= hash >>> 12;
  return (hash >>> 0) / 2 ** 31 - 1;
}

export const images = Array.from({ length: 16 }, (_, at) => {
  const centre = [east + (at % 8) * 8, north + Math.floor(at / 8) * 16, 450];
  const half = [(width * gsd) / 2, (height * gsd) / 2];
  return {
    id: at + 1, file: `DJI_${String(at + 1).padStart(4, "0")}.jpg`, width, height, levels, camera: 1, oriented: at !== 15,
    position: centre, sigma_m: [0.01, 0.01, 0.02],
    footprint: [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([e, n]) => [centre[0] + e * half[0], centre[1] + n * half[1]]),
  };
});

const truth = new Map(Array.from({ length: 10 }, (_, at) => [`P${at + 1}`, [east + 8 + 5 * at + 0.3 * at, north + 3 + 2.1 * ((at * 7) % 10), 50]]));

/** Where an image shows a point truly. */
export function truePixel(name, image) {
  const [e, n] = truth.get(name);
  return [(e - image.position[0]) / gsd + width / 2 + 0.37, (image.position[1] - n) / gsd + height / 2 - 0.21];
}
/** Those of P10 are farther off than a target is looked for. */
const missOf = (name, image) => [0, 1].map((axis) => chance(name, image.file, axis) * (name === "P10" ? 3 : 4) + (name === "P10" ? 14 : 0));
const isIn = ([x, y]) => x > 5 && y > 5 && x < width - 5 && y < height - 5;

export class World {
  entries = [];
  isOriented = true;
  number = 0;
  first = Object.fromEntries([...truth].map(([name, position], at) => [name, { role: at % 4 === 3 ? "check" : "control", position, sigma_m: [0.01, 0.01, 0.015], marks: {} }]));
  told = () => {};

  /** Points with their marks, as the edits that are in force made them. */
  get points() {
    const points = new Map(Object.entries(structuredClone(this.first)));
    for (const { command, undone } of this.entries) if (!undone) this.#apply(points, command);
    return points;
  }

  edit(command) {
    const [word] = command;
    if (word === "undo") {
      const last = this.entries.findLast((entry) => !entry.undone);
      if (!last) return { status: 409, json: { error: "there is nothing to undo" } };
      last.undone = true;
    } else if (word === "redo") {
      const next = this.#redo();
      if (!next) return { status: 409, json: { error: "there is nothing to redo" } };
      next.undone = false;
    } else {
      const error = this.#wrong(command);
      if (error) return { status: 400, json: { error } };
      this.entries = this.entries.filter((entry) => !entry.undone);
      this.entries.push({ number: this.number + 1, time: new Date(1.79e12 + this.number * 1000).toISOString(), command, undone: false });
    }
    ++this.number;
    this.told(this.number);
    return { status: 200, json: { number: this.number } };
  }

  edits() {
    const undo = this.entries.findLast((entry) => !entry.undone);
    return { number: this.number, undo: undo?.command.join(" ") ?? null, redo: this.#redo()?.command.join(" ") ?? null, entries: this.entries, left_out: 0 };
  }

  #redo() {
    return this.entries.find((entry) => entry.undone);
  }

  #wrong([word, name, image]) {
    if (word === "point") return undefined;
    if (!this.points.has(name)) return `there is no point ${name}`;
    return (word === "mark" || word === "unmark") && !images.some((one) => one.file === image) ? `there is no image ${image}` : undefined;
  }

  #apply(points, [word, name, ...rest]) {
    const number = (text) => (text === undefined || text === "-" ? null : Number(text));
    if (word === "point") points.set(name, { role: rest[0], position: rest.slice(1, 4).map(number), sigma_m: rest.length > 4 ? rest.slice(4, 7).map(number) : [0.02, 0.02, 0.02], marks: points.get(name)?.marks ?? {} });
    if (word === "remove") points.delete(name);
    if (word === "role") points.get(name).role = rest[0];
    if (word === "mark") points.get(name).marks[rest[0]] = { pixel: [Number(rest[1]), Number(rest[2])], sigma_px: rest[3] ? Number(rest[3]) : 0.5 };
    if (word === "unmark") delete points.get(name).marks[rest[0]];
  }

  /** Of a mark against the truth. */
  #tests(name, image, mark) {
    const [x, y] = truth.has(name) ? truePixel(name, image) : mark.pixel;
    const residual = [mark.pixel[0] - x, mark.pixel[1] - y];
    return { residual_px: residual, w: residual.map((one) => one / mark.sigma_px), redundancy: [0.6, 0.7], detectable_px: [4.1 * mark.sigma_px, 4 * mark.sigma_px] };
  }

  control() {
    const points = [...this.points].map(([name, point], at) => ({
      name, role: point.role, position: point.position, sigma_m: point.sigma_m,
      adjusted: truth.has(name) ? point.position.map((one, axis) => one + 0.006 * chance(name, axis)) : null,
      difference_m: truth.has(name) ? point.position.map((_, axis) => (at === 4 && axis === 2 ? -0.081 : 0.02 * chance(name, axis))) : null,
      difference_sigma_m: truth.has(name) ? [0.011, 0.012, 0.019] : null,
      marks: Object.entries(point.marks).map(([file, mark]) => {
        const image = images.find((one) => one.file === file);
        const tests = this.#tests(name, image, mark);
        return { image: image.id, file, pixel: mark.pixel, sigma_px: mark.sigma_px, residual_px: tests.residual_px, w: tests.w[0], redundancy: 0.6, detectable_px: 4.1 * mark.sigma_px };
      }),
    }));
    return { points, sigma0: 1.02 };
  }

  places(name) {
    const point = this.points.get(name);
    if (!point) return undefined;
    const marks = Object.entries(point.marks);
    const places = truth.has(name)
      ? images.filter((image) => image.oriented && isIn(truePixel(name, image)) && isIn(truePixel(name, image).map((one, axis) => one + missOf(name, image)[axis]))).map((image) => {
          const [x, y] = truePixel(name, image);
          const [dx, dy] = missOf(name, image);
          const size = 6 / Math.sqrt(1 + marks.length);
          return {
            image: image.id, file: image.file, pixel: [x + dx, y + dy], ellipse: { major_px: size, minor_px: size * 0.6, angle_deg: 35 }, marked: image.file in point.marks,
            hidden: false,
            sigma_after_m: marks.length ? (0.02 * (1 + 0.03 * Math.abs(chance(image.file)))) / Math.sqrt(marks.length) : null,
          };
        })
      : [];
    places.sort((a, b) => Number(a.marked) - Number(b.marked) || (a.sigma_after_m ?? 0) - (b.sigma_after_m ?? 0) || Math.abs(chance(a.file)) - Math.abs(chance(b.file)));
    const marked = marks.length < 2 ? null : {
      position: point.position.map((one, axis) => one + 0.004 * chance(name, axis)), sigma_m: [0.008, 0.008, 0.02],
      difference_m: [0, 1, 2].map((axis) => 0.004 * chance(name, axis)), difference_sigma_m: [0.012, 0.012, 0.025], sigma0: 1, redundancy: 2 * marks.length - 3,
      marks: marks.map(([file, mark]) => {
        const image = images.find((one) => one.file === file);
        return { image: image.id, ...this.#tests(name, image, mark) };
      }),
    };
    return { places, given_disagrees: false, contradicting: marks.filter(([file, mark]) => Math.max(...this.#tests(name, images.find((one) => one.file === file), mark).residual_px.map(Math.abs)) > 20).map(([file]) => images.find((one) => one.file === file).id), marked };
  }

  /** P1 and P2 have tags with their numbers; one is of no point. */
  tags(id) {
    const image = images.find((one) => one.id === id);
    const own = ["P1", "P2"].filter((name) => isIn(truePixel(name, image))).map((name) => ({ family: "aruco-4x4-50", number: Number(name.slice(1)), pixel: truePixel(name, image), sigma_px: 0.02 }));
    return { tags: [...own, ...(id === 3 ? [{ family: "aruco-4x4-50", number: 77, pixel: [50, 60], sigma_px: 0.03 }] : [])] };
  }

  refine({ image: id, pixel }) {
    const image = images.find((one) => one.id === id);
    for (const name of truth.keys()) {
      const [x, y] = truePixel(name, image);
      if (Math.hypot(x - pixel[0], y - pixel[1]) > 8) continue;
      const sigma = 0.04 + 0.01 * Math.abs(chance(image.file, name));
      return { pixel: [x + 0.03 * chance(name, id, "x"), y + 0.03 * chance(name, id, "y")], covariance_px2: [sigma ** 2, 0, sigma ** 2], sigma_px: sigma, kind: "chequerboard" };
    }
    return undefined;
  }

  images() {
    const marks = [...this.points.values()].flatMap((point) => Object.keys(point.marks));
    return { tile_px: tilePx, images: images.map((image) => ({ ...image, marks: marks.filter((file) => file === image.file).length })) };
  }

  map() {
    return { crs: "EPSG:32633", crs_name: "WGS 84 / UTM zone 33N", proj4: "+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs", unit: "m", bounds: [east - 40, north - 30, east + 96, north + 46] };
  }

  residuals(id) {
    return { points: Array.from({ length: 400 }, (_, at) => [0, 1].map((axis) => ((chance("p", id, at, axis) + 1) / 2) * [width, height][axis]).concat([0, 1].map((axis) => 0.6 * chance("r", id, at, axis)))) };
  }
}

// What the ground looks like: fields, and a chequerboard at every point.
function grey(image, targets, x, y) {
  for (const [tx, ty] of targets) {
    const [dx, dy] = [x - tx, y - ty];
    if (dx * dx + dy * dy < 144) return dx * dy > 0 ? 235 : 25;
  }
  const [e, n] = [(x - width / 2) * gsd + image.position[0] - east, image.position[1] - north - (y - height / 2) * gsd];
  return Math.round(120 + 30 * Math.sin(e / 3.1) * Math.cos(n / 4.3) + 18 * Math.sin(e * 3 + n * 2) + 10 * chance("t", Math.round(e * 8), Math.round(n * 8)));
}

const crcs = Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n >>> 0;
});
function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type), data]);
  let crc = 0xffffffff;
  for (const byte of body) crc = crcs[(crc ^ byte) & 255] ^ (crc >>> 8);
  const [length, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
  length.writeUInt32BE(data.length);
  sum.writeUInt32BE((crc ^ 0xffffffff) >>> 0);
  return Buffer.concat([length, body, sum]);
}

/** A tile as PNG; nothing where there is none. */
export function tile(id, z, x, y) {
  const image = images.find((one) => one.id === id);
  const reduction = 2 ** (levels - 1 - z);
  if (!image || !(z >= 0 && z < levels)) return undefined;
  const [wide, high] = [Math.ceil(width / reduction), Math.ceil(height / reduction)];
  const [w, h] = [Math.min(tilePx, wide - x * tilePx), Math.min(tilePx, high - y * tilePx)];
  if (!(w > 0 && h > 0 && x >= 0 && y >= 0)) return undefined;
  const rows = Buffer.alloc((w + 1) * h);
  const targets = [...truth.keys()].map((name) => truePixel(name, image));
  for (let row = 0; row < h; ++row)
    for (let column = 0; column < w; ++column)
      rows[row * (w + 1) + column + 1] = grey(image, targets, (x * tilePx + column + 0.5) * reduction, (y * tilePx + row + 0.5) * reduction);
  const head = Buffer.alloc(13);
  head.writeUInt32BE(w, 0);
  head.writeUInt32BE(h, 4);
  head.set([8, 0, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk("IHDR", head), chunk("IDAT", deflateSync(rows, { level: 1 })), chunk("IEND", Buffer.alloc(0))]);
}

// SPDX-License-Identifier: Apache-2.0
// Reads the cloud by ranges of bytes, decompresses its nodes, applies edits and finds points under the pointer, beside the page's own thread.
import createLazPerf from "laz-perf/lib/worker/laz-perf.js";
import wasm from "laz-perf/lib/worker/laz-perf.wasm?url";

import type { CloudRegion } from "../../lib/types";
import { type Neighbour, placedBy } from "./corner";
import { type CloudHeader, type CloudNode, cloudHeader, headBytes, hierarchyPage, tree } from "./cloud_file";
import { type FromWorker, type LoadedNode, type PickRay, type PickedPoint, type PlacedPoint, sigmaCode, type Spread, type ToWorker } from "./messages";
import { editedClass } from "./regions";
import type { Triple } from "./viewpoint";

/** What is kept of a node: exact coordinates, and all that edits and picks want. */
interface Held {
  cells: Int32Array;
  classes: Uint8Array;
  sigmas: Float32Array;
  images: Uint8Array;
  colours: Uint8Array;
  /** After edits; -1: removed. */
  now: Int16Array;
}

/** What of the decompressor is used; its own types want those of Emscripten. */
interface LazPerf {
  HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(at: number): void;
  ChunkDecoder: new () => { open(format: number, recordBytes: number, at: number): void; getPoint(at: number): void; delete(): void };
}

const firstBytes = 16384;
const atOnce = 4;
const held = new Map<number, Held>();
const reading = new Map<number, AbortController>();
let waiting: number[] = [];
let address = "";
/** Grows with every cloud that is opened: what is on its way for another one is dropped. */
let opening = 0;
let header: CloudHeader | undefined;
let nodes: CloudNode[] = [];
let regions: CloudRegion[] = [];
const perf = (createLazPerf as unknown as (options: { locateFile: () => string }) => Promise<LazPerf>)({ locateFile: () => wasm });

const say = (message: FromWorker, transfer: Transferable[] = []): void => self.postMessage(message, { transfer });
const why = (error: unknown): string => (error instanceof Error ? error.message : String(error));

async function range(at: number, bytes: number, signal?: AbortSignal): Promise<ArrayBuffer> {
  const response = await fetch(address, { headers: { Range: `bytes=${at}-${at + bytes - 1}` }, ...(signal ? { signal } : {}) });
  if (response.status !== 206) throw new Error(`${response.status} ${response.statusText}`);
  return await response.arrayBuffer();
}

async function open(): Promise<void> {
  const mine = ++opening;
  for (const control of reading.values()) control.abort();
  for (const one of [reading, held]) one.clear();
  [waiting, header, nodes] = [[], undefined, []];
  let head = await range(0, firstBytes);
  const size = headBytes(new DataView(head));
  if (size > head.byteLength) head = await range(0, size);
  const opened = cloudHeader(new DataView(head));
  const found = [];
  const pages = [{ at: opened.hierarchyAt, bytes: opened.hierarchyBytes }];
  const seen = new Set<number>(); // pages of a damaged file may refer to each other
  for (let page = pages.pop(); page; page = pages.pop()) {
    if (page.bytes <= 0 || seen.has(page.at)) continue;
    seen.add(page.at);
    const read = hierarchyPage(new DataView(await range(page.at, page.bytes)));
    found.push(...read.nodes);
    pages.push(...read.pages);
  }
  if (mine !== opening) return;
  [header, nodes] = [opened, tree(opened, found)];
  say({ opened: header, nodes });
}

function expanded(perf: LazPerf, head: CloudHeader, node: CloudNode, chunk: ArrayBuffer): Held {
  const made: Held = {
    cells: new Int32Array(3 * node.points), classes: new Uint8Array(node.points), sigmas: new Float32Array(node.points),
    images: new Uint8Array(node.points), colours: new Uint8Array(3 * node.points), now: new Int16Array(node.points),
  };
  const bytes = perf._malloc(chunk.byteLength);
  const record = perf._malloc(head.recordBytes);
  perf.HEAPU8.set(new Uint8Array(chunk), bytes);
  const decoder = new perf.ChunkDecoder();
  try {
    decoder.open(head.format, head.recordBytes, bytes);
    let view = new DataView(perf.HEAPU8.buffer, record, head.recordBytes);
    for (let i = 0; i < node.points; ++i) {
      decoder.getPoint(record);
      if (view.buffer !== perf.HEAPU8.buffer) view = new DataView(perf.HEAPU8.buffer, record, head.recordBytes);
      for (let axis = 0; axis < 3; ++axis) {
        made.cells[3 * i + axis] = view.getInt32(4 * axis, true);
        made.colours[3 * i + axis] = head.format > 6 ? view.getUint8(31 + 2 * axis) : 128; // the upper of two bytes
      }
      made.classes[i] = view.getUint8(16);
      if (head.sigmaAt >= 0) made.sigmas[i] = view.getFloat32(head.sigmaAt, true);
      if (head.imagesAt >= 0) made.images[i] = view.getUint8(head.imagesAt);
    }
  } finally {
    decoder.delete();
    perf._free(bytes);
    perf._free(record);
  }
  return made;
}

function applyEdits(head: CloudHeader, one: Held): void {
  const { scale, offset } = head;
  if (!regions.length) return one.now.set(one.classes);
  for (let i = 0; i < one.classes.length; ++i) {
    const e = offset[0] + scale[0] * (one.cells[3 * i] as number);
    const n = offset[1] + scale[1] * (one.cells[3 * i + 1] as number);
    const h = offset[2] + scale[2] * (one.cells[3 * i + 2] as number);
    one.now[i] = editedClass(regions, one.classes[i] as number, e, n, h);
  }
}

function painted(one: Held): { colours: Uint8Array; traits: Uint8Array } {
  const [colours, traits] = [new Uint8Array(4 * one.classes.length), new Uint8Array(4 * one.classes.length)];
  for (let i = 0; i < one.classes.length; ++i) {
    for (let band = 0; band < 3; ++band) colours[4 * i + band] = one.colours[3 * i + band] as number;
    colours[4 * i + 3] = (one.now[i] as number) < 0 ? 0 : 255;
    traits[4 * i] = Math.max(one.now[i] as number, 0);
    traits[4 * i + 1] = sigmaCode(one.sigmas[i] as number);
    traits[4 * i + 2] = one.images[i] as number;
  }
  return { colours, traits };
}

function forView(head: CloudHeader, index: number, node: CloudNode, one: Held): LoadedNode {
  const positions = new Float32Array(one.cells.length);
  for (let axis = 0; axis < 3; ++axis) {
    const [scale, by] = [head.scale[axis] as number, (head.offset[axis] as number) - (node.centre[axis] as number)];
    for (let i = axis; i < positions.length; i += 3) positions[i] = by + scale * (one.cells[i] as number);
  }
  return { node: index, positions, ...painted(one), ...(index === 0 ? { spread: spreadOf(head, one) } : {}) };
}

function spreadOf(head: CloudHeader, one: Held): Spread {
  const between = (values: Float64Array | Uint8Array | Float32Array): [number, number] => {
    const sorted = values.slice().sort();
    return [0.02, 0.98].map((share) => sorted[Math.round(share * (sorted.length - 1))] ?? 0) as [number, number];
  };
  const heights = Float64Array.from(one.classes, (_, i) => head.offset[2] + head.scale[2] * (one.cells[3 * i + 2] as number));
  const [low, high] = between(one.sigmas.filter((sigma) => sigma > 0)).map(sigmaCode) as [number, number];
  return { height: between(heights), sigma: [low, high], images: between(one.images) };
}

async function load(index: number): Promise<void> {
  const [head, node] = [header, nodes[index]];
  if (!head || !node || held.has(index)) return;
  const control = new AbortController();
  reading.set(index, control);
  try {
    const chunk = await range(node.at, node.bytes, control.signal);
    const made = expanded(await perf, head, node, chunk);
    if (control.signal.aborted) return;
    applyEdits(head, made);
    held.set(index, made);
    const loaded = forView(head, index, node, made);
    say({ loaded }, [loaded.positions.buffer, loaded.colours.buffer, loaded.traits.buffer]);
  } catch (error) {
    if (!control.signal.aborted) say({ missed: index, why: why(error) });
  } finally {
    if (reading.get(index) === control) reading.delete(index);
    next();
  }
}

function next(): void {
  while (reading.size < atOnce) {
    const index = waiting.shift();
    if (index === undefined) return;
    if (!reading.has(index)) void load(index);
  }
}

function reapply(): void {
  const head = header;
  if (head)
    for (const [node, one] of held) {
      applyEdits(head, one);
      const { colours, traits } = painted(one);
      say({ edited: node, colours, traits }, [colours.buffer, traits.buffer]);
    }
  say({ applied: true });
}

/** The point nearest to the ray in its cone; one that is eight radii farther away loses against the rim. */
function picked(head: CloudHeader, ray: PickRay, among: number[]): PickedPoint | null {
  const { scale, offset } = head;
  const [ox, oy, oz] = ray.origin;
  const [dx, dy, dz] = ray.direction;
  let [best, from, at] = [Infinity, undefined as Held | undefined, 0];
  for (const index of among) {
    const [one, node] = [held.get(index), nodes[index]];
    if (!one || !node || !meets(ray, node)) continue;
    for (let i = 0; i < one.now.length; ++i) {
      if ((one.now[i] as number) < 0) continue;
      const x = offset[0] + scale[0] * (one.cells[3 * i] as number) - ox;
      const y = offset[1] + scale[1] * (one.cells[3 * i + 1] as number) - oy;
      const z = offset[2] + scale[2] * (one.cells[3 * i + 2] as number) - oz;
      const along = x * dx + y * dy + z * dz;
      const radius = ray.radius_m + ray.slope * along;
      const off = x * x + y * y + z * z - along * along;
      if (along <= 0 || off > radius * radius) continue;
      const score = along + 8 * Math.sqrt(Math.max(off, 0));
      if (score < best) [best, from, at] = [score, one, i];
    }
  }
  if (!from) return null;
  const sigma = from.sigmas[at] as number;
  return {
    at: [0, 1, 2].map((axis) => (offset[axis] as number) + (scale[axis] as number) * ((from as Held).cells[3 * at + axis] as number)) as [number, number, number],
    sigma_m: sigma > 0 ? sigma : null, class: from.now[at] as number, images: from.images[at] as number,
  };
}

/** Points about a place, the nearest first: enough to know the surface by. */
function neighboursOf(head: CloudHeader, place: Triple, reach: number, among: number[]): Neighbour[] {
  const { scale, offset } = head;
  const [least, most] = [48, 96];
  for (let [radius, turn] = [reach / 2, 0]; ; radius *= 2, ++turn) {
    const found: (Neighbour & { away: number })[] = [];
    for (const index of among) {
      const [one, node] = [held.get(index), nodes[index]];
      if (!one || !node || node.centre.some((along, axis) => Math.abs(along - (place[axis] as number)) > node.half + radius)) continue;
      for (let i = 0; i < one.now.length; ++i) {
        if ((one.now[i] as number) < 0) continue;
        const at: Triple = [offset[0] + scale[0] * (one.cells[3 * i] as number), offset[1] + scale[1] * (one.cells[3 * i + 1] as number), offset[2] + scale[2] * (one.cells[3 * i + 2] as number)];
        const away = Math.hypot(at[0] - place[0], at[1] - place[1], at[2] - place[2]);
        if (away < radius) found.push({ at, sigma_m: one.sigmas[i] as number, away });
      }
    }
    if (found.length >= least || turn === 6) return found.sort((a, b) => a.away - b.away).slice(0, most);
  }
}

function placed(head: CloudHeader, ray: PickRay, among: number[], pointing_m: number): PlacedPoint | null {
  const point = picked(head, ray, among);
  if (!point) return null;
  const along = point.at.reduce((sum, value, axis) => sum + (value - (ray.origin[axis] as number)) * (ray.direction[axis] as number), 0);
  return placedBy(ray, point, neighboursOf(head, point.at, ray.radius_m + ray.slope * along, among), pointing_m);
}

function meets(ray: PickRay, node: CloudNode): boolean {
  const by = node.centre.map((along, axis) => along - (ray.origin[axis] as number)) as [number, number, number];
  const along = by.reduce((sum, one, axis) => sum + one * (ray.direction[axis] as number), 0);
  const radius = node.half * Math.sqrt(3);
  const reach = radius + ray.radius_m + ray.slope * Math.max(along + radius, 0);
  return along > -radius && by.reduce((sum, one) => sum + one * one, 0) - along * along < reach * reach;
}

self.onmessage = (event: MessageEvent<ToWorker>): void => {
  const message = event.data;
  if ("open" in message) {
    [address, regions] = [message.open, message.regions];
    const mine = opening + 1;
    open().catch((error: unknown) => mine === opening && say({ failed: why(error) }));
  } else if ("load" in message) {
    if (!reading.has(message.load) && !waiting.includes(message.load)) waiting.push(message.load);
    next();
  } else if ("drop" in message) {
    for (const index of message.drop) held.delete(index);
  } else if ("cancel" in message) {
    waiting = waiting.filter((index) => !message.cancel.includes(index));
    for (const index of message.cancel) {
      reading.get(index)?.abort();
      reading.delete(index); // it may be asked for again at once
    }
  } else if ("regions" in message) {
    regions = message.regions;
    reapply();
  } else if (header) {
    const { pick, among, ask, pointing_m } = message;
    say({ picked: pointing_m === undefined ? picked(header, pick, among) : placed(header, pick, among, pointing_m), ask });
  }
};

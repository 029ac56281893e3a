// SPDX-License-Identifier: Apache-2.0
// The head of a cloud that is sorted into an octree (COPC 1.0, Hobu 2021): what it says of itself, and its nodes. Pure functions of bytes.
import type { Triple } from "./viewpoint";

export interface CloudHeader {
  points: number;
  format: number;
  recordBytes: number;
  scale: Triple;
  offset: Triple;
  lowest: Triple;
  highest: Triple;
  /** Of the cube of the whole cloud. */
  centre: Triple;
  half: number;
  hierarchyAt: number;
  hierarchyBytes: number;
  /** Within a record; -1: the file has none. */
  sigmaAt: number;
  imagesAt: number;
}

export interface CloudNode {
  level: number;
  position: Triple;
  /** Where its chunk lies in the file. */
  at: number;
  bytes: number;
  points: number;
  /** Indices of its parts. */
  children: number[];
  /** Of its cube, in the map. */
  centre: Triple;
  half: number;
}

const headerBytes = 375;
/** Records of 6 to 8 without extra bytes. */
const baseBytes: Record<number, number> = { 6: 30, 7: 36, 8: 38 };
const typeBytes = [0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8];

const text = (view: DataView, at: number, size: number): string => {
  let out = "";
  for (let i = 0; i < size && view.getUint8(at + i) !== 0; ++i) out += String.fromCharCode(view.getUint8(at + i));
  return out;
};
const long = (view: DataView, at: number): number => Number(view.getBigUint64(at, true));
const triple = (view: DataView, at: number, step = 8): Triple => [0, 1, 2].map((axis) => view.getFloat64(at + step * axis, true)) as Triple;

/** How many bytes from the beginning hold everything that `cloudHeader` reads. */
export const headBytes = (view: DataView): number => view.getUint32(96, true);

/** Throws where it is no such file. */
export function cloudHeader(view: DataView): CloudHeader {
  if (text(view, 0, 4) !== "LASF" || view.byteLength < 589 || text(view, headerBytes + 2, 16) !== "copc") throw new Error("no COPC file");
  const format = view.getUint8(104) & 63;
  const base = baseBytes[format];
  if (base === undefined) throw new Error(`point format ${format}`);
  const info = headerBytes + 54;
  const [sigmaAt, imagesAt] = extraBytes(view, base);
  return {
    format,
    points: long(view, 247),
    recordBytes: view.getUint16(105, true),
    scale: triple(view, 131),
    offset: triple(view, 155),
    highest: triple(view, 179, 16),
    lowest: triple(view, 187, 16),
    centre: triple(view, info),
    half: view.getFloat64(info + 24, true),
    hierarchyAt: long(view, info + 40),
    hierarchyBytes: long(view, info + 48),
    sigmaAt,
    imagesAt,
  };
}

function extraBytes(view: DataView, base: number): [number, number] {
  let [sigmaAt, imagesAt] = [-1, -1];
  const records = view.getUint32(100, true);
  for (let record = 0, at = headerBytes; record < records && at + 54 <= view.byteLength; ++record) {
    const size = view.getUint16(at + 20, true);
    if (text(view, at + 2, 16) === "LASF_Spec" && view.getUint16(at + 18, true) === 4) {
      let within = base;
      for (let one = at + 54; one + 192 <= Math.min(at + 54 + size, view.byteLength); one += 192) {
        const [type, name] = [view.getUint8(one + 2), text(view, one + 4, 32)];
        if (name === "sigma_m" && type === 9) sigmaAt = within;
        if (name === "images" && type === 1) imagesAt = within;
        within += typeBytes[type] || view.getUint8(one + 3);
      }
    }
    at += 54 + size;
  }
  return [sigmaAt, imagesAt];
}

/** One page of the hierarchy; `pages` are those that it refers to. */
export function hierarchyPage(view: DataView): { nodes: Omit<CloudNode, "children" | "centre" | "half">[]; pages: { at: number; bytes: number }[] } {
  const nodes = [];
  const pages = [];
  for (let at = 0; at + 32 <= view.byteLength; at += 32) {
    const [level, x, y, z] = [0, 4, 8, 12].map((by) => view.getInt32(at + by, true)) as [number, number, number, number];
    const [offset, bytes, points] = [long(view, at + 16), view.getInt32(at + 24, true), view.getInt32(at + 28, true)];
    if (points === -1) pages.push({ at: offset, bytes });
    else nodes.push({ level, position: [x, y, z] as Triple, at: offset, bytes, points });
  }
  return { nodes, pages };
}

/** The nodes with their cubes and parts; the root is the first. A node whose parent is missing is left out. */
export function tree(header: CloudHeader, found: Omit<CloudNode, "children" | "centre" | "half">[]): CloudNode[] {
  const nodes: CloudNode[] = [];
  const indices = new Map<string, number>();
  const key = (level: number, [x, y, z]: Triple): string => `${level}-${x}-${y}-${z}`;
  for (const one of [...found].sort((a, b) => a.level - b.level)) {
    const parent = one.level > 0 ? indices.get(key(one.level - 1, one.position.map((along) => along >> 1) as Triple)) : undefined;
    if (one.level > 0 && parent === undefined) continue;
    const half = header.half / 2 ** one.level;
    const centre = header.centre.map((along, axis) => along - header.half + (2 * (one.position[axis] as number) + 1) * half) as Triple;
    indices.set(key(one.level, one.position), nodes.length);
    if (parent !== undefined) nodes[parent]?.children.push(nodes.length);
    nodes.push({ ...one, children: [], centre, half });
  }
  return nodes;
}

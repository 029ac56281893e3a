#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// Is CLOUD.copc.laz what CLOUD.las is, for the readers of others? laz-perf reads it as LAZ, copc as an octree: the same
// records in another order, bit for bit, each once; every point within the cube of its node; and a query by bounds and
// resolution gives every point there is in them, or one of every cell of that size that holds any.
//
// usage: node bench/copc.js CLOUD.copc.laz CLOUD.las      (once before: npm install copc laz-perf)
// Exit code 1 when anything is wrong; without the npm packages nothing is compared, and that is said.
const fs = require('fs');

const from = name => require(require.resolve(name, { paths: [process.cwd(), __dirname] }));
let createLazPerf, Copc;
try {
  ({ createLazPerf } = from('laz-perf'));
  ({ Copc } = from('copc'));
} catch {
  console.log('skipped: the npm packages copc and laz-perf are not installed here (npm install copc laz-perf)');
  process.exit(0);
}

// A set of records, told by sums that do not depend on their order.
class RecordSet {
  constructor() { this.count = this.a = this.b = 0; }
  add(bytes, at, size) {
    let a = 0x811c9dc5, b = 0x1234567;
    for (let i = at; i < at + size; ++i) {
      a = Math.imul(a ^ bytes[i], 0x01000193);
      b = Math.imul(b + bytes[i], 0x5bd1e995) ^ (b >>> 15);
    }
    this.count += 1;
    this.a = (this.a + (a >>> 0)) % 2 ** 48;
    this.b = (this.b + ((b ^ (b >>> 13)) >>> 0)) % 2 ** 48;
  }
  equals(other) { return this.count === other.count && this.a === other.a && this.b === other.b; }
}

let wrong = 0;
function verdict(what, right, more = '') {
  console.log(`${right ? 'right' : 'WRONG'}: ${what}${more}`);
  wrong += !right;
}

async function main([copcPath, lasPath]) {
  const perf = await createLazPerf();
  const las = fs.readFileSync(lasPath), laz = fs.readFileSync(copcPath);
  const points = Number(las.readBigUInt64LE(247)), size = las.readUInt16LE(105), pointsAt = las.readUInt32LE(96);
  let bytesRead = 0;
  const get = async (begin, end) => {
    bytesRead += end - begin;
    return new Uint8Array(laz.subarray(begin, end));
  };
  const copc = await Copc.create(get);
  const { scale, offset, min, max } = copc.header, { cube, spacing } = copc.info;
  const place = (bytes, at) => [0, 1, 2].map(k => bytes.readInt32LE(at + 4 * k) * scale[k] + offset[k]);

  const all = new RecordSet();
  for (let i = 0; i < points; ++i) all.add(las, pointsAt + i * size, size);

  // As LAZ.
  const file = perf._malloc(laz.length), record = perf._malloc(size);
  perf.HEAPU8.set(laz, file);
  const reader = new perf.LASZip();
  reader.open(file, laz.length);
  const asLaz = new RecordSet();
  for (let i = 0; i < reader.getCount(); ++i) {
    reader.getPoint(record);
    asLaz.add(perf.HEAPU8, record, size);
  }
  perf._free(file);
  verdict('laz-perf reads the records of the LAS', asLaz.equals(all), `, ${asLaz.count} points`);

  // As an octree.
  const nodes = {}, pages = [copc.info.rootHierarchyPage];
  while (pages.length) {
    const page = await Copc.loadHierarchyPage(get, pages.pop());
    Object.assign(nodes, page.nodes);
    pages.push(...Object.values(page.pages));
  }
  const boxOf = key => {
    const [level, ...at] = key.split('-').map(Number), side = (cube[3] - cube[0]) / 2 ** level;
    return [...at.map((a, k) => cube[k] + a * side), ...at.map((a, k) => cube[k] + (a + 1) * side)];
  };
  const inside = (p, box, by = 0) => p.every((x, k) => x >= box[k] - by && x <= box[k + 3] + by);
  const read = async node =>
    Buffer.from(await Copc.loadPointDataBuffer(get, copc.header, node, perf));
  const asTree = new RecordSet();
  let deepest = 0, outside = 0, largest = 0;
  for (const [key, node] of Object.entries(nodes)) {
    deepest = Math.max(deepest, Number(key.split('-')[0]));
    largest = Math.max(largest, node.pointCount);
    if (!node.pointCount) continue;
    const bytes = await read(node), box = boxOf(key);
    for (let at = 0; at < bytes.length; at += size) {
      asTree.add(bytes, at, size);
      outside += !inside(place(bytes, at), box, 1e-3 * scale[0]);  // doubles of northings in the millions keep 1e-9
    }
  }
  verdict('copc reads the records of the LAS', asTree.equals(all),
          `, ${Object.keys(nodes).length} nodes on ${deepest + 1} levels, at most ${largest} points in one`);
  verdict('points lie in their nodes', outside === 0);
  verdict('the cloud lies in the cube', inside(min, cube) && inside(max, cube));
  verdict('the coordinate system is there', (copc.wkt || '') === wktOf(las));

  // A view of the middle tenth of the plan: everything, and as much as a resolution asks for.
  const view = [0, 1, 2].map(k => (min[k] + max[k]) / 2 - (k < 2 ? 0.16 : 1) * (max[k] - min[k]));
  view.push(...[0, 1, 2].map(k => (min[k] + max[k]) / 2 + (k < 2 ? 0.16 : 1) * (max[k] - min[k])));
  const wanted = new RecordSet();
  for (let i = 0; i < points; ++i)
    if (inside(place(las, pointsAt + i * size), view)) wanted.add(las, pointsAt + i * size, size);
  for (const level of [0, 1, 2, deepest]) {
    const found = new RecordSet(), cells = new Set(), cell = spacing / 2 ** level;
    const cellOf = p => p.map((x, k) => Math.floor((x - cube[k]) / cell)).join(' ');
    bytesRead = 0;
    for (const [key, node] of Object.entries(nodes)) {
      const box = boxOf(key);
      if (Number(key.split('-')[0]) > level || !node.pointCount) continue;
      if ([0, 1, 2].some(k => box[k] > view[k + 3] || box[k + 3] < view[k])) continue;
      const bytes = await read(node);
      for (let at = 0; at < bytes.length; at += size) {
        const p = place(bytes, at);
        if (!inside(p, view)) continue;
        found.add(bytes, at, size);
        cells.add(cellOf(p));
      }
    }
    let missed = 0;
    const margin = [0, 1, 2].map(k => view[k] + cell).concat([3, 4, 5].map(k => view[k] - cell));
    if (level < deepest)  // cells cut by the view's border may show a point outside it
      for (let i = 0; i < points; ++i) {
        const p = place(las, pointsAt + i * size);
        missed += inside(p, margin) && !cells.has(cellOf(p));
      }
    verdict(`view at ${cell.toPrecision(3)} m`, level < deepest ? missed === 0 : found.equals(wanted),
            `: ${found.count} of ${wanted.count} points from ${(bytesRead / laz.length * 100).toFixed(1)} % of the file`);
  }
  console.log(`${las.length} bytes as LAS, ${laz.length} as COPC (1/${(las.length / laz.length).toFixed(2)})`);
  process.exit(wrong ? 1 : 0);
}

function wktOf(las) {
  let at = las.readUInt16LE(94);
  for (let i = 0; i < las.readUInt32LE(100); ++i) {
    const bytes = las.readUInt16LE(at + 20);
    if (las.readUInt16LE(at + 18) === 2112) return las.toString('utf8', at + 54, at + 54 + bytes).replace(/\0+$/, '');
    at += 54 + bytes;
  }
  return '';
}

if (process.argv.length !== 4) {
  console.log('usage: node bench/copc.js CLOUD.copc.laz CLOUD.las');
  process.exit(2);
}
main(process.argv.slice(2));

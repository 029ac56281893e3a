#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// Does laz-perf read from CLOUD.laz, record by record and bit for bit, what CLOUD.las holds?
//
// usage: node bench/laz.js CLOUD.laz CLOUD.las      (once before: npm install laz-perf)
// Exit code 1 when anything differs; without the npm package nothing is compared, and that is said.
const fs = require('fs');

let createLazPerf;
try {
  ({ createLazPerf } = require(require.resolve('laz-perf', { paths: [process.cwd(), __dirname] })));
} catch {
  console.log('skipped: the npm package laz-perf is not installed here (npm install laz-perf)');
  process.exit(0);
}

async function main([lazPath, lasPath]) {
  const perf = await createLazPerf();
  const laz = fs.readFileSync(lazPath), las = fs.readFileSync(lasPath);
  const points = Number(las.readBigUInt64LE(247)), recordBytes = las.readUInt16LE(105), pointsAt = las.readUInt32LE(96);
  const file = perf._malloc(laz.length), record = perf._malloc(recordBytes);
  perf.HEAPU8.set(laz, file);
  const reader = new perf.LASZip();
  reader.open(file, laz.length);
  let different = Math.abs(reader.getCount() - points) + Number(reader.getPointLength() !== recordBytes);
  for (let i = 0; i < points && !different; ++i) {
    reader.getPoint(record);
    const at = pointsAt + i * recordBytes;
    if (Buffer.from(perf.HEAPU8.buffer, record, recordBytes).compare(las, at, at + recordBytes) !== 0) {
      console.log(`record ${i} differs`);
      ++different;
    }
  }
  console.log(`${different ? 'DIFFERENT' : 'same'}: ${points} points, ${las.length} bytes as LAS, ${laz.length} as LAZ ` +
              `(1/${(las.length / laz.length).toFixed(2)})`);
  process.exit(different ? 1 : 0);
}

if (process.argv.length !== 4) {
  console.log('usage: node bench/laz.js CLOUD.laz CLOUD.las');
  process.exit(2);
}
main(process.argv.slice(2));

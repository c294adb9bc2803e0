// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Environment: LATTICED_WRITE_STREAMS, the program of tests/core/codec/draco3d that writes the streams to decode.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { ChunkDecoder } from '@src/decode/chunk_decoder';
import { NUMBERS_PER_POINT, type ChunkForm } from '@src/decode/chunk_form';
import { DecodePool, type PendingChunk } from '@src/decode/decode_pool';
import { FakeWorker } from './support/fake_worker';

const wasm = new Uint8Array(readFileSync('node_modules/draco3d/draco_decoder.wasm')).buffer;

function quantisedForm(points: number, normalBits: number): ChunkForm {
  return { encoding: 'quantised', points, normals: normalBits > 0, normalBits };
}

test('one decoder reads every stream of the server\'s writer to the integers that were written', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'latticed-streams-'));
  execFileSync(process.env.LATTICED_WRITE_STREAMS!, [folder]);
  const decoder = await ChunkDecoder.create(wasm);
  const names = readdirSync(folder).filter((name) => name.endsWith('.drc'));
  assert.equal(names.length, 1758);
  let decodeAgain = (): unknown => undefined;
  for (const name of names) {
    const bytes = readFileSync(join(folder, name.replace('.drc', '.bin')));
    const expected = new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
    const sizes = [1, 66, 2112, 12_288, 17_952, 65_535];
    const points = sizes.find((size) => [3 * size, 5 * size].includes(expected.length))!;
    const normals = expected.length === 5 * points;
    const data = new Uint8Array(readFileSync(join(folder, name)));

    const decode = () => decoder.decode(data, { encoding: 'draco', points, normals, normalBits: 8 });
    const { points: got, extent } = decode();

    if (points === sizes.at(-1)) decodeAgain = decode;
    assert.equal(got.length, NUMBERS_PER_POINT * points);
    let wrong = 0;  // one assertion per value would take seconds
    for (let i = 0; i < points; ++i) {
      for (let axis = 0; axis < 3; ++axis) {
        const value = got[6 * i + axis];
        if (value !== expected[3 * i + axis] || value < extent[axis] || value > extent[3 + axis]) ++wrong;
      }
      for (let axis = 0; normals && axis < 2; ++axis) {
        if (got[6 * i + 4 + axis] !== expected[3 * points + 2 * i + axis]) ++wrong;
      }
    }
    assert.equal(wrong, 0, name);
  }
  rmSync(folder, { recursive: true });

  const { draco } = (decoder as unknown as { draco: { draco: { HEAP32: Int32Array } } }).draco;
  const { length } = draco.HEAP32;
  for (let i = 0; i < 100; ++i) decodeAgain();
  assert.equal(draco.HEAP32.length, length, 'what a chunk takes in WebAssembly is given back');
});

test('a stream of other points than announced, and bytes that are none, are refused; the next is decoded', async () => {
  const decoder = await ChunkDecoder.create(wasm);
  const good = new Uint8Array([1, 0, 2, 0, 3, 0]);

  assert.throws(() => decoder.decode(new Uint8Array([1, 2, 3]), { encoding: 'draco', points: 1, normals: false, normalBits: 0 }),
    /no Draco stream/);
  assert.throws(() => decoder.decode(good, quantisedForm(2, 0)), /6 bytes, not 12/);
  assert.throws(() => decoder.decode(good, { encoding: 'raw', points: 1, normals: true, normalBits: 0 }), /6 bytes, not 24/);
  assert.deepEqual([...decoder.decode(good, quantisedForm(1, 0)).points], [1, 2, 3, 0, 0, 0]);
});

test('planar integers are read with narrow and with wide normals, from odd addresses too', async () => {
  const decoder = await ChunkDecoder.create(wasm);
  const planes = [1, 2, 300, 400, 65535, 6];
  const positions = new Uint8Array(Uint16Array.from(planes).buffer);
  const narrow = new Uint8Array([0, ...positions, 7, 8, 9, 254]).subarray(1);
  const wide = new Uint8Array([...positions, ...new Uint8Array(Uint16Array.from([7, 800, 9, 1022]).buffer)]);

  assert.deepEqual([...decoder.decode(narrow, quantisedForm(2, 8)).points], [1, 300, 65535, 0, 7, 9, 2, 400, 6, 0, 8, 254]);
  assert.deepEqual([...decoder.decode(wide, quantisedForm(2, 10)).points], [1, 300, 65535, 0, 7, 9, 2, 400, 6, 0, 800, 1022]);
});

test('raw floats are read with and without normals, and extents hold them', async () => {
  const decoder = await ChunkDecoder.create(wasm);
  const values = new Float32Array([0.5, -1, 2, 0, 0, 1, -3, 4, 5, 1, 0, 0]);
  const form = { encoding: 'raw', points: 2, normals: true, normalBits: 0 } as const;

  const { points, extent } = decoder.decode(new Uint8Array(values.buffer), form);
  const bare = decoder.decode(new Uint8Array(values.slice(0, 6).buffer), { ...form, normals: false });

  assert.deepEqual([...points], [...values]);
  assert.deepEqual([...extent], [-3, -1, 2, 0.5, 4, 5]);
  assert.deepEqual([...bare.points], [0.5, -1, 2, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
});

test('small chunks go to a worker together; it has two batches, what waits can be cancelled, and memory that came back is used', async () => {
  const workers = [new FakeWorker(wasm), new FakeWorker(wasm)];
  const pool = new DecodePool(workers, wasm);
  const [SMALL, LARGE] = [3000, 8000]; // two small ones are a batch, a large one is another
  const decode = (first: number, points: number): PendingChunk =>
    pool.decode(new Uint8Array(Uint16Array.from({ length: 3 * points }, () => first).buffer), quantisedForm(points, 0));
  const chunks = [SMALL, SMALL, LARGE, SMALL, LARGE, SMALL, LARGE, SMALL].map((points, i) => decode(i, points));
  await Promise.resolve();

  const sizes = (): number[][] => workers.map(({ batches }) => batches.map(({ jobs }) => jobs.length));
  assert.deepEqual(sizes(), [[2, 1], [1, 1]]);
  assert.deepEqual([chunks[5].cancel(), chunks[0].cancel(), chunks[4].cancel()], [true, false, false]);
  assert.equal(pool.pending, 7);
  await Promise.all(workers.map((worker) => worker.work()));
  await Promise.all(workers.map((worker) => worker.work()));
  const decoded = await Promise.all(chunks.filter((_, i) => i !== 5).map((chunk) => chunk.result));
  pool.giveBack(decoded[2]);
  const again = decode(9, LARGE);
  await Promise.resolve();
  const { reuse } = workers.flatMap(({ batches }) => batches).at(0)!.jobs[0];

  assert.deepEqual(decoded.map(({ points }) => points[0]), [0, 1, 2, 3, 4, 6, 7]);
  assert.equal(reuse, decoded[2].points.buffer);
  await Promise.all(workers.map((worker) => worker.work()));
  assert.equal((await again.result).points.buffer, reuse);
});

test('what a worker cannot decode rejects that chunk alone; a worker that is not there rejects all', async () => {
  const worker = new FakeWorker(wasm);
  const pool = new DecodePool([worker], wasm);
  const bad = pool.decode(new Uint8Array([1]), quantisedForm(1, 0));
  const good = pool.decode(new Uint8Array([1, 0, 2, 0, 3, 0]), quantisedForm(1, 0));
  await Promise.resolve();
  await worker.work();
  await assert.rejects(bad.result, /1 bytes, not 6/);
  assert.equal((await good.result).points[2], 3);

  const lost = pool.decode(new Uint8Array([1]), quantisedForm(1, 0));
  worker.onerror!({ message: 'HTTP 404' });

  await assert.rejects(lost.result, /HTTP 404/);
  await assert.rejects(pool.decode(new Uint8Array([1]), quantisedForm(1, 0)).result, /HTTP 404/);
});

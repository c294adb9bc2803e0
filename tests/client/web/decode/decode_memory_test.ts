// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Environment: LATTICED_DECODER_WASM, the module of client/decoder.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync, realpathSync } from 'node:fs';
import { join, parse } from 'node:path';
import { test } from 'node:test';
import { setImmediate } from 'node:timers/promises';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { ChunkDecoder } from '@src/decode/chunk_decoder';
import type { ChunkForm } from '@src/decode/chunk_form';
import { decoderWasm, FakeWorker, loadDraco3d, poolOf } from '../support/fake_worker';

const UPDATES = 10_000;
const WARM_UP = 1000;
const MOST_BYTES = 500_000; // an update may leave 50 bytes

const golden = join(realpathSync('test'), '../golden');
const streams = readdirSync(golden).filter((name) => /^cloud_66_.*drc$/.test(name)).map((name) => {
  const [points, positionBits, normalBits] = parse(name).name.split('_').slice(1).map(Number);
  const form: ChunkForm = { encoding: 'draco', points, normals: normalBits > 0, positionBits, normalBits };
  return { data: new Uint8Array(readFileSync(join(golden, name))), form };
});
const foreign = streams[0].data.slice(); // for draco3d
--foreign[6]; // an earlier minor version

setFlagsFromString('--expose_gc');
const collectGarbage = runInNewContext('gc') as () => void;

/** Bytes of objects and of buffers after a garbage collection, and of both decoders' memory. */
async function taken(decoder: ChunkDecoder): Promise<{ objects: number; buffers: number; modules: number[] }> {
  collectGarbage();
  await setImmediate();
  collectGarbage();
  const { heapUsed, arrayBuffers } = process.memoryUsage();
  const { own, stock } = decoder as unknown as {
    own: { module: { memory: WebAssembly.Memory } }; stock: Promise<{ draco: { HEAP32: Int32Array } }>;
  };
  return { objects: heapUsed, buffers: arrayBuffers,
    modules: [own.module.memory.buffer.byteLength, (await stock).draco.HEAP32.byteLength] };
}

test('10,000 updates leave the memory of the pool and of both decoders as it is: some chunks are cancelled, foreign, damaged or of other bits', async () => {
  const decoder = await ChunkDecoder.create(decoderWasm, loadDraco3d);
  const worker = new FakeWorker(false, Promise.resolve(decoder));
  const pool = poolOf(worker);
  let [decoded, refused, cancelled] = [0, 0, 0];
  const update = async (number: number): Promise<void> => {
    const { form } = streams[0];
    const chunks = streams.map(({ data, form: ownForm }) => pool.decode(data, ownForm));
    if (number % 10 === 0) chunks.push(pool.decode(foreign, form), pool.decode(foreign.slice(0, 50), form));
    if (number % 3 === 0 && pool.decode(streams[0].data, form).cancel()) ++cancelled;
    await setImmediate(); // as with a worker, whose answers are tasks; Node 18's test runner then forgets promises
    await worker.work();
    for (const result of await Promise.allSettled(chunks.map((chunk) => chunk.result))) {
      if (result.status === 'rejected') ++refused;
      else ++decoded, pool.giveBack(result.value);
    }
  };
  for (let number = 0; number < WARM_UP; ++number) await update(number);
  const before = await taken(decoder);
  [decoded, refused, cancelled] = [0, 0, 0];

  for (let number = 0; number < UPDATES; ++number) await update(number);

  assert.deepEqual([decoded, refused, cancelled], [UPDATES * streams.length + UPDATES / 10, UPDATES / 10, Math.ceil(UPDATES / 3)]);
  const after = await taken(decoder);
  for (const kind of ['objects', 'buffers'] as const) {
    assert.ok(after[kind] <= before[kind] + MOST_BYTES, `${before[kind]} bytes of ${kind} became ${after[kind]}`);
  }
  assert.deepEqual(after.modules, before.modules);
  assert.equal(pool.pending, 0);
});

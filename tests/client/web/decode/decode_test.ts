// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Environment: that of support/written_streams.ts; LATTICED_DECODER_WASM, the module of client/decoder.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync, realpathSync } from 'node:fs';
import { join, parse } from 'node:path';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { answerBatch } from '@src/decode/answer_batch';
import { ChunkDecoder } from '@src/decode/chunk_decoder';
import { NUMBERS_PER_POINT, type ChunkForm, type DecodedChunk } from '@src/decode/chunk_form';
import type { PendingChunk } from '@src/decode/decode_pool';
import { OwnDecoder } from '@src/decode/own_decoder';
import { decoderWasm, FakeWorker, loadDraco3d, poolOf } from '../support/fake_worker';
import { RandomNumbers } from '../support/random_numbers';
import { readStreams, SIZES, wrongNumbers } from '../support/written_streams';

const form = { encoding: 'quantised', points: 1, normals: false, positionBits: 16, normalBits: 0 } as const;
const quantisedForm = (points: number, normalBits: number): ChunkForm => ({ ...form, points, normals: normalBits > 0, normalBits });

const streams = readStreams();

async function memoryOf(decoder: ChunkDecoder): Promise<number> {
  const { own, stock } = decoder as unknown as {
    own?: { module: { memory: WebAssembly.Memory } }; stock?: Promise<{ draco: { HEAP32: Int32Array } }>;
  };
  return (own?.module.memory.buffer.byteLength ?? 0) + ((await stock)?.draco.HEAP32.length ?? 0);
}

for (const [which, module] of [['ours', decoderWasm], ['draco3d', undefined]] as const) {
  test(`${which} reads every stream of the server's writer to the integers that were written`, async () => {
    const decoder = await ChunkDecoder.create(module, async () => {
      assert.equal(which, 'draco3d', 'draco3d is not needed');
      return loadDraco3d();
    });
    assert.ok(which === 'draco3d' || module, 'LATTICED_DECODER_WASM is not set');
    for (let first = 0; first < streams.length; first += 16) {
      const batch = streams.slice(first, first + 16);
      (await decoder.decode(batch)).results.forEach((result, i) => {
        assert.ok(!(result instanceof Error), String(result));
        assert.equal(wrongNumbers(batch[i], result), 0, batch[i].name);
      });
    }
    const largest = streams.filter(({ form: { points } }) => points === SIZES.at(-1));
    const before = await memoryOf(decoder);
    for (let i = 0; i < 20; ++i) await decoder.decode(largest.slice(0, 4));
    assert.equal(await memoryOf(decoder), before, 'what chunks take in WebAssembly is used again');
  });
}

test('streams of an earlier writer decode for ever', async () => {
  const golden = join(realpathSync('test'), '../golden'); // tests/client/decoder/golden_streams_test.cc describes it
  const names = readdirSync(golden).filter((name) => !name.endsWith('.points'));
  assert.equal(names.length, 18 + 10);
  for (const name of names) {
    const [points, positionBits, normalBits] = parse(name).name.split('_').slice(1).map(Number);
    const expected = new Uint8Array(readFileSync(join(golden, `${parse(name).name}.points`)));
    const encoding = name.endsWith('.drc') ? 'draco' : 'meshopt';

    const { points: got } = await decoded(new Uint8Array(readFileSync(join(golden, name))),
      { encoding, points, normals: normalBits > 0, positionBits, normalBits });

    assert.deepEqual(new Uint8Array(got.buffer, got.byteOffset, got.byteLength), expected, name);
  }
});

test('the module takes at most 12 KB on the line, and imports nothing', () => {
  assert.ok(gzipSync(new Uint8Array(decoderWasm!)).length <= 12 * 1024);
  assert.deepEqual(WebAssembly.Module.imports(new WebAssembly.Module(decoderWasm!)), []);
});

test('damaged streams are refused or read as draco3d reads them, and do no harm to their neighbours', async () => {
  const seed = Math.floor(Math.random() * 2 ** 32);
  const random = new RandomNumbers(seed);
  const small = streams.filter(({ form: { points, positionBits, normalBits } }) =>
    points === 2112 && positionBits === 12 && normalBits === 8);
  assert.ok(small.length >= 16);
  const ours = await OwnDecoder.create(decoderWasm!);
  const stock = await loadDraco3d();
  let [accepted, compared] = [0, 0];
  for (let round = 0; round < 300; ++round) {
    const good = [small[random.below(small.length)], small[random.below(small.length)]];
    const data = small[random.below(small.length)].data.slice(0, undefined);
    for (let changes = 1 + random.below(3); changes > 0; --changes) data[random.below(data.length)] = random.below(256);
    const cut = random.below(4) === 0 ? data.slice(0, random.below(data.length)) : data;
    const damaged = { ...good[0], data: cut };

    const chunks = [good[0], damaged, good[1]];
    const points = chunks.map(() => new Uint16Array(NUMBERS_PER_POINT * damaged.form.points));
    const [before, extent, after] = ours.decode(chunks, points);

    const context = `seed ${seed}, round ${round}`;
    assert.equal(wrongNumbers(good[0], { points: points[0], extent: before! }), 0, context);
    assert.equal(wrongNumbers(good[1], { points: points[2], extent: after! }), 0, context);
    if (!extent) continue;
    ++accepted;
    const numbers = new Uint16Array(points[1].length);
    try {
      stock.decode(cut, damaged.form, numbers);
    } catch {
      continue; // draco3d checks more of what does not say points
    }
    ++compared;
    assert.deepEqual(points[1], numbers, context);
  }
  assert.ok(compared > 0, `of ${accepted}`);
});

test('draco3d is loaded once, when a stream needs it, and asked for again after a failure', async () => {
  let loaded = 0;
  const decoder = await ChunkDecoder.create(decoderWasm, async () => {
    if (++loaded === 1) throw new Error('no answer');
    return loadDraco3d();
  });
  const { data, form: written } = streams[0];
  const foreign = data.slice();
  foreign[6] = foreign[6] === 3 ? 2 : 1; // another minor version

  const { results: [own] } = await decoder.decode([{ data, form: written }]);
  assert.ok(!(own instanceof Error));
  assert.equal(loaded, 0);
  assert.match(String((await decoder.decode([{ data: foreign, form: written }])).results[0]), /no answer/);
  await decoder.decode([{ data: foreign, form: written }, { data: foreign, form: written }]);
  assert.equal(loaded, 2);
});

test('a stream of other points than announced, and bytes that are none, are refused; the next is decoded', async () => {
  const decoder = await ChunkDecoder.create(decoderWasm, loadDraco3d);
  const good = new Uint8Array([1, 0, 2, 0, 3, 0]);

  const { results: [noDraco, short, noFloats, points] } = await decoder.decode([
    { data: new Uint8Array([1, 2, 3]), form: { ...form, encoding: 'draco' } },
    { data: good, form: quantisedForm(2, 0) },
    { data: good, form: { ...form, encoding: 'raw', normals: true } },
    { data: good, form },
  ]);

  assert.match(String(noDraco), /no Draco stream/);
  assert.match(String(short), /6 bytes, not 12/);
  assert.match(String(noFloats), /6 bytes, not 24/);
  assert.deepEqual([...(points as DecodedChunk).points], [1, 2, 3, 0, 0, 0]);
});

/** Decodes a chunk alone. */
async function decoded(data: Uint8Array, chunkForm: ChunkForm): Promise<DecodedChunk> {
  const { results: [result] } = await (await ChunkDecoder.create(decoderWasm, loadDraco3d)).decode([{ data, form: chunkForm }]);
  if (result instanceof Error) throw result;
  return result;
}

test('planar integers are read with narrow and with wide normals, from odd addresses too', async () => {
  const planes = [1, 2, 300, 400, 65535, 6];
  const positions = new Uint8Array(Uint16Array.from(planes).buffer);
  const narrow = new Uint8Array([0, ...positions, 7, 8, 9, 254]).subarray(1);
  const wide = new Uint8Array([...positions, ...new Uint8Array(Uint16Array.from([7, 800, 9, 1022]).buffer)]);

  assert.deepEqual([...(await decoded(narrow, quantisedForm(2, 8))).points], [1, 300, 65535, 0, 7, 9, 2, 400, 6, 0, 8, 254]);
  assert.deepEqual([...(await decoded(wide, quantisedForm(2, 10))).points], [1, 300, 65535, 0, 7, 9, 2, 400, 6, 0, 800, 1022]);
});

test('raw floats are read with and without normals, and extents hold them', async () => {
  const values = new Float32Array([0.5, -1, 2, 0, 0, 1, -3, 4, 5, 1, 0, 0]);
  const floats: ChunkForm = { ...form, encoding: 'raw', points: 2, normals: true };

  const { points, extent } = await decoded(new Uint8Array(values.buffer), floats);
  const bare = await decoded(new Uint8Array(values.slice(0, 6).buffer), { ...floats, normals: false });

  assert.deepEqual([...points], [...values]);
  assert.deepEqual([...extent], [-3, -1, 2, 0.5, 4, 5]);
  assert.deepEqual([...bare.points], [0.5, -1, 2, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
});

test('small chunks go to a worker together; it has eight batches, what waits can be cancelled, and memory that came back is used', async () => {
  const workers = [new FakeWorker(), new FakeWorker()];
  const pool = poolOf(...workers);
  const [SMALL, LARGE] = [12_000, 32_000]; // two small ones are a batch, a large one is another
  const decode = (first: number, points: number): PendingChunk =>
    pool.decode(new Uint8Array(Uint16Array.from({ length: 3 * points }, () => first).buffer), quantisedForm(points, 0));
  const chunks = [SMALL, SMALL, ...Array<number>(15).fill(LARGE), SMALL, SMALL].map((points, i) => decode(i, points));
  await Promise.resolve();

  const sizes = (): number[][] => workers.map(({ batches }) => batches.map(({ chunks: { length } }) => length));
  assert.deepEqual(sizes(), [[2, 1, 1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 1, 1]]);
  assert.deepEqual([chunks[17].cancel(), chunks[0].cancel(), chunks[16].cancel()], [true, false, false]);
  assert.equal(pool.pending, 18);
  await Promise.all(workers.map((worker) => worker.work()));
  await Promise.all(workers.map((worker) => worker.work()));
  const decoded = await Promise.all(chunks.filter((_, i) => i !== 17).map((chunk) => chunk.result));
  assert.deepEqual(decoded.map(({ points }) => points[0]), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 18]);
  const memory = decoded[0].points.buffer;
  assert.equal(decoded[1].points.buffer, memory);

  const reused = async (): Promise<ArrayBuffer | undefined> => {
    const chunk = decode(19, SMALL);
    await Promise.resolve();
    const [{ reuse }] = workers.flatMap(({ batches }) => batches);
    await Promise.all(workers.map((worker) => worker.work()));
    assert.equal((await chunk.result).points[0], 19);
    return reuse;
  };
  pool.giveBack(decoded[0]);
  assert.equal(await reused(), undefined, 'a chunk of the batch is in use');
  pool.giveBack(decoded[1]);
  assert.equal(await reused(), memory);
});

test('a decoder that fails answers each chunk of the batch', async () => {
  const batch = { kind: 'batch', id: 7, data: new Uint8Array(2), chunks: [{ bytes: 1, form }, { bytes: 1, form }] } as const;
  const trapped = { decode: () => Promise.reject(new WebAssembly.RuntimeError('unreachable')) } as unknown as ChunkDecoder;

  const answer = await answerBatch(batch, Promise.resolve(trapped));
  const unmade = await answerBatch(batch, Promise.reject(new Error('no memory')));

  assert.deepEqual(answer.chunks, Array(2).fill('RuntimeError: unreachable'));
  assert.deepEqual(unmade.chunks, Array(2).fill('Error: no memory'));
  assert.equal(answer.id, 7);
});

test('what a worker cannot decode rejects that chunk alone; a worker that is not there rejects all', async () => {
  const worker = new FakeWorker();
  const pool = poolOf(worker);
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

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Environment: as decode_test.ts.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MeshoptDecoder } from 'meshoptimizer/decoder';
import { ChunkDecoder } from '@src/decode/chunk_decoder';
import { NUMBERS_PER_POINT, type ChunkData } from '@src/decode/chunk_form';
import { decoderWasm, loadDraco3d } from '../support/fake_worker';
import { RandomNumbers } from '../support/random_numbers';
import { readStreams, wrongNumbers } from '../support/written_streams';

const streams = readStreams().map((stream) =>
  ({ ...stream, data: stream.meshopt, form: { ...stream.form, encoding: 'meshopt' as const } }));
const VERTEX_BYTES = 2 * NUMBERS_PER_POINT;

function decoderWith(module: ArrayBuffer | undefined): Promise<ChunkDecoder> {
  return ChunkDecoder.create(module, async () => {
    assert.fail('draco3d is not needed');
    return loadDraco3d();
  });
}

test('every meshopt stream of the server decodes to the integers that were written', async () => {
  const decoder = await decoderWith(decoderWasm);
  for (let first = 0; first < streams.length; first += 16) {
    const batch = streams.slice(first, first + 16);
    (await decoder.decode(batch)).results.forEach((result, i) => {
      assert.ok(!(result instanceof Error), String(result));
      assert.equal(wrongNumbers(batch[i], result), 0, batch[i].name);
    });
  }
});

test('damaged streams are refused or read as meshoptimizer reads them, and do no harm to their neighbours', async () => {
  const seed = Math.floor(Math.random() * 2 ** 32);
  const random = new RandomNumbers(seed);
  await MeshoptDecoder.ready;
  const decoder = await decoderWith(decoderWasm);
  const small = streams.filter(({ form: { points } }) => points === 2112);
  let [accepted, refused] = [0, 0];
  for (let round = 0; round < 300; ++round) {
    const good = small[random.below(small.length)];
    const data = good.data.slice();
    for (let changes = 1 + random.below(3); changes > 0; --changes) data[random.below(data.length)] = random.below(256);
    const damaged: ChunkData = { form: good.form, data: random.below(4) === 0 ? data.slice(0, random.below(data.length)) : data };

    const { results: [before, result, after] } = await decoder.decode([good, damaged, good]);

    const context = `seed ${seed}, round ${round}`;
    for (const neighbour of [before, after]) {
      assert.ok(!(neighbour instanceof Error), context);
      assert.equal(wrongNumbers(good, neighbour), 0, context);
    }
    if (result instanceof Error) {
      assert.match(result.message, /^a chunk is no meshopt stream of its view$/);
      ++refused;
      continue;
    }
    ++accepted;
    const expected = new Uint16Array(NUMBERS_PER_POINT * good.form.points);
    MeshoptDecoder.decodeVertexBuffer(new Uint8Array(expected.buffer), good.form.points, VERTEX_BYTES, damaged.data);
    assert.deepEqual(result.points, expected, context);
  }
  assert.ok(accepted > 5 && refused > 20, `${accepted} accepted, ${refused} refused, seed ${seed}`);
});

test('without the module, chunks of meshopt are refused with the reason', async () => {
  const { results: [result] } = await (await decoderWith(undefined)).decode([streams[0]]);
  assert.ok(result instanceof Error);
  assert.equal(result.message, 'this browser has no WebAssembly SIMD, which meshopt chunks need');
});

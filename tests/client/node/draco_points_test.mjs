// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node draco_points_test.mjs EXAMPLE GOLDEN: the built client/node, and tests/client/golden
// Compares what the example decodes with the golden points, and with draco3d's own floats.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, parse } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';

const [example, golden] = process.argv.slice(2);
const built = (name) => import(pathToFileURL(join(example, 'dist', name)));
const { DracoPoints } = await built('draco_points.js');
const { OwnDecoder } = await built('own_decoder.js');
const { StockDecoder } = await built('stock_decoder.js');
const draco = await createRequire(join(example, 'x'))('draco3d').createDecoderModule({});

const own = await OwnDecoder.create(new Uint8Array(readFileSync(join(example, 'decoder.wasm'))));
const ours = new DracoPoints(own, () => assert.fail('draco3d is not needed'));
const stock = new DracoPoints(undefined, StockDecoder.create);

/** POSITION or NORMAL of each point as draco3d reads them: floats. */
function floats(decoder, cloud, type) {
  const id = decoder.GetAttributeId(cloud, type);
  const values = new draco.DracoFloat32Array();
  if (id >= 0) decoder.GetAttributeFloatForAllPoints(cloud, decoder.GetAttribute(cloud, id), values);
  return Float32Array.from({ length: values.size() }, (_, i) => values.GetValue(i));
}

function readByDraco3d(data) {
  const [buffer, decoder, cloud] = [new draco.DecoderBuffer(), new draco.Decoder(), new draco.PointCloud()];
  buffer.Init(data, data.length);
  assert.ok(decoder.DecodeBufferToPointCloud(buffer, cloud).ok());
  return { positions: floats(decoder, cloud, draco.POSITION), normals: floats(decoder, cloud, draco.NORMAL) };
}

const RANGE = 8; // of the positions in the golden streams
const streams = readdirSync(golden).filter((name) => /^cloud_.*drc$/.test(name)).map((name) => {
  const [points, bits, normalBits] = parse(name).name.split('_').slice(1).map(Number);
  const data = new Uint8Array(readFileSync(join(golden, name)));
  const expected = new Uint16Array(new Uint8Array(readFileSync(join(golden, name.replace('.drc', '.points')))).buffer);
  return { name, chunk: { data, points }, expected, grid: { bits, normalBits, step: RANGE / (2 ** bits - 1) } };
});
const near = (got, expected, most) =>
  got.length === expected.length && got.every((value, i) => Math.abs(value - expected[i]) <= most);

test('decoder.wasm and draco3d give the integers that were written, and the floats that draco3d makes of them', async () => {
  assert.equal(streams.length, 10);
  for (const { name, chunk, expected, grid } of streams) {
    const { positions, normals } = readByDraco3d(chunk.data);
    assert.deepEqual(own.decode([chunk], grid), [expected], name);
    const [points] = await ours.decode([chunk], grid);
    assert.ok(near(points.positions, positions, 2 ** -23 * RANGE), name);
    assert.ok(near(points.normals, normals, 2 ** -22), name);
    assert.deepEqual(await stock.decode([chunk], grid), [points], name);
  }
});

test('chunks that come together are decoded together', async () => {
  const { chunk, grid } = streams.find(({ grid: { normalBits } }) => normalBits > 0);
  const [alone] = await ours.decode([chunk], grid);
  assert.deepEqual(await ours.decode(Array(40).fill(chunk), grid), Array(40).fill(alone));
});

test('draco3d decodes what decoder.wasm refuses; bytes that are no Draco, and another number of points, are errors', async () => {
  const { chunk, expected, grid } = streams.find(({ chunk: { points } }) => points > 1);
  const foreign = { ...chunk, data: chunk.data.slice() };
  --foreign.data[6]; // an earlier minor version
  assert.deepEqual(own.decode([foreign], grid), [undefined]);
  let loaded = 0;
  const both = new DracoPoints(own, () => (++loaded, StockDecoder.create()));

  const [first, second] = await both.decode([chunk, foreign], grid);

  assert.equal(loaded, 1);
  assert.equal(first.positions.length, expected.length / 2);
  assert.deepEqual(second, first);
  await assert.rejects(both.decode([{ data: new Uint8Array([1, 2, 3]), points: 1 }], grid), /no Draco point cloud/);
  await assert.rejects(both.decode([{ ...chunk, points: 1 }], grid), /holds 66 points instead of 1/);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node compare_streams.mjs FOLDER NODE_MODULES
// Decodes the streams of write_streams.cc with draco3d and with meshoptimizer, the decoders of browsers, and compares all
// integers.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const [folder, modules] = process.argv.slice(2);
const packages = createRequire(join(modules, 'x'));
const draco3d = packages('draco3d');
const { MeshoptDecoder: meshopt } = packages('meshoptimizer/decoder');
await meshopt.ready;
const draco = await draco3d.createDecoderModule({});

// Returns point times components as one array; null if the stream has no such attribute.
function integers(decoder, cloud, type) {
  const id = decoder.GetAttributeId(cloud, type);
  if (id < 0) return null;
  const attribute = decoder.GetAttribute(cloud, id);
  const values = new draco.DracoInt32Array();
  if (!decoder.GetAttributeInt32ForAllPoints(cloud, attribute, values)) throw new Error('no integers');
  const result = Array.from({ length: values.size() }, (_, i) => values.GetValue(i));
  draco.destroy(values);
  return result;
}

// The bits of POSITION or NORMAL; 0 if the stream has no such attribute.
function quantisationBits(decoder, cloud, type) {
  const id = decoder.GetAttributeId(cloud, type);
  if (id < 0) return 0;
  const transform = type === draco.POSITION ? new draco.AttributeQuantizationTransform()
                                            : new draco.AttributeOctahedronTransform();
  if (!transform.InitFromAttribute(decoder.GetAttribute(cloud, id))) throw new Error('no transform');
  const bits = transform.quantization_bits();
  draco.destroy(transform);
  return bits;
}

function decode(bytes) {
  const buffer = new draco.DecoderBuffer();
  buffer.Init(bytes, bytes.length);
  const decoder = new draco.Decoder();
  const types = [draco.POSITION, draco.NORMAL];
  for (const type of types) decoder.SkipAttributeTransform(type);
  const isMesh = decoder.GetEncodedGeometryType(buffer) === draco.TRIANGULAR_MESH;
  const cloud = isMesh ? new draco.Mesh() : new draco.PointCloud();
  const status = isMesh ? decoder.DecodeBufferToMesh(buffer, cloud)
                        : decoder.DecodeBufferToPointCloud(buffer, cloud);
  if (!status.ok()) throw new Error(status.error_msg());
  const faces = isMesh ? cloud.num_faces() : 0;
  const points = cloud.num_points();
  const bits = types.map((type) => quantisationBits(decoder, cloud, type)).join('/');
  const values = types.flatMap((type) => integers(decoder, cloud, type) ?? []);
  for (const object of [cloud, decoder, buffer]) draco.destroy(object);
  return { isMesh, points, faces, bits, values };
}

// Returns point times components as one array, positions before normals.
function decodeMeshopt(bytes, points, hasNormals) {
  const vertices = new Uint16Array(6 * points);
  meshopt.decodeVertexBuffer(new Uint8Array(vertices.buffer), points, 12, bytes);
  const numbers = (places) => Array.from({ length: points }, (_, i) => places.map((place) => vertices[6 * i + place])).flat();
  assert.ok(numbers(hasNormals ? [3] : [3, 4, 5]).every((number) => number === 0));
  return [...numbers([0, 1, 2]), ...(hasNormals ? numbers([4, 5]) : [])];
}

let meshes = 0;
const streams = {};  // number of streams by number of points
const pairsOfBits = new Set();
const names = readdirSync(folder).filter((name) => name.endsWith('.drc'));
for (const name of names) {
  const bytes = readFileSync(join(folder, name.replace('.drc', '.bin')));
  const expected = new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  const { isMesh, points, faces, bits, values } = decode(readFileSync(join(folder, name)));
  const same = values.length === expected.length && values.every((value, i) => value === expected[i]);
  if (!same) throw new Error(`${name}: not the integers that were written`);
  const read = decodeMeshopt(readFileSync(join(folder, name.replace('.drc', '.meshopt'))), points, values.length > 3 * points);
  if (read.length !== expected.length || !read.every((value, i) => value === expected[i])) {
    throw new Error(`${name}: meshoptimizer reads other integers`);
  }
  if (isMesh && faces !== points - 2) throw new Error(`${name}: ${faces} faces for ${points} points`);
  meshes += isMesh ? 1 : 0;
  streams[points] = (streams[points] ?? 0) + 1;
  pairsOfBits.add(bits);
}
assert.deepEqual(streams, { 1: 14, 66: 504 + 1152, 2112: 14 + 32, 12288: 14, 17952: 14, 65535: 14 });
assert.equal(pairsOfBits.size, 9 * 8);
assert.equal(meshes, 587);
console.log(`${names.length} streams, ${meshes} of them meshes, hold the integers that were written`);

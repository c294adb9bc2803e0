// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node compare_streams.mjs FOLDER NODE_MODULES
// Decodes what write_streams.cc wrote with draco3d, the decoder that browsers use, and compares all
// integers.
import { readdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const [folder, modules] = process.argv.slice(2);
const draco3d = createRequire(join(modules, 'x'))('draco3d');
const draco = await draco3d.createDecoderModule({});

// As an array of point times components; null where the stream has no such attribute.
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

function decode(bytes) {
  const buffer = new draco.DecoderBuffer();
  buffer.Init(bytes, bytes.length);
  const decoder = new draco.Decoder();
  for (const type of [draco.POSITION, draco.NORMAL]) decoder.SkipAttributeTransform(type);
  const isMesh = decoder.GetEncodedGeometryType(buffer) === draco.TRIANGULAR_MESH;
  const cloud = isMesh ? new draco.Mesh() : new draco.PointCloud();
  const status = isMesh ? decoder.DecodeBufferToMesh(buffer, cloud)
                        : decoder.DecodeBufferToPointCloud(buffer, cloud);
  if (!status.ok()) throw new Error(status.error_msg());
  const faces = isMesh ? cloud.num_faces() : 0;
  const points = cloud.num_points();
  const found = [integers(decoder, cloud, draco.POSITION), integers(decoder, cloud, draco.NORMAL)];
  for (const object of [cloud, decoder, buffer]) draco.destroy(object);
  return { isMesh, points, faces, values: found.flatMap((values) => values ?? []) };
}

let meshes = 0;
const names = readdirSync(folder).filter((name) => name.endsWith('.drc'));
for (const name of names) {
  const bytes = readFileSync(join(folder, name.replace('.drc', '.bin')));
  const expected = new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  const { isMesh, points, faces, values } = decode(readFileSync(join(folder, name)));
  const same = values.length === expected.length && values.every((value, i) => value === expected[i]);
  if (!same) throw new Error(`${name}: not the integers that were written`);
  if (isMesh && faces !== points - 2) throw new Error(`${name}: ${faces} faces for ${points} points`);
  meshes += isMesh ? 1 : 0;
}
if (names.length !== 135 || meshes !== 30) throw new Error(`${names.length} streams, ${meshes} meshes`);
console.log(`${names.length} streams, ${meshes} of them meshes, hold the integers that were written`);

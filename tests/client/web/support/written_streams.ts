// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Environment: LATTICED_WRITE_STREAMS, the program of tests/core/codec/draco3d that writes the streams.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, parse } from 'node:path';
import { NUMBERS_PER_POINT, type ChunkForm, type DecodedChunk } from '@src/decode/chunk_form';

/** A stream of the server's writer, and the integers that it holds. */
export interface Stream {
  readonly name: string;
  readonly data: Uint8Array;
  readonly meshopt: Uint8Array; // of the same vertices
  readonly form: ChunkForm;
  readonly integers: Uint32Array; // x y z of all points, then s t
}

export const SIZES = [1, 66, 2112, 12_288, 17_952, 65_535]; // numbers of points

export function readStreams(): Stream[] {
  const folder = mkdtempSync(join(tmpdir(), 'latticed-streams-'));
  execFileSync(process.env.LATTICED_WRITE_STREAMS!, [folder]);
  const names = readdirSync(folder).filter((name) => name.endsWith('.drc'));
  const streams = names.map((name): Stream => {
    const bytes = readFileSync(join(folder, name.replace('.drc', '.bin')));
    const integers = new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
    const [positionBits, normalBits] = parse(name).name.split('_').slice(1).map(Number);
    const points = integers.length / (normalBits > 0 ? 5 : 3);
    assert.ok(SIZES.includes(points), name);
    const read = (kind: string): Uint8Array => new Uint8Array(readFileSync(join(folder, `${parse(name).name}.${kind}`)));
    return { name, data: read('drc'), meshopt: read('meshopt'), integers,
      form: { encoding: 'draco', points, normals: normalBits > 0, positionBits, normalBits } };
  });
  rmSync(folder, { recursive: true });
  assert.equal(streams.length, 1758);
  return streams;
}
/** Counts the wrong numbers: one assertion for each would take seconds. */
export function wrongNumbers({ form: { points, normals }, integers }: Stream, { points: got, extent }: DecodedChunk): number {
  let wrong = got.length === NUMBERS_PER_POINT * points ? 0 : 1;
  const low = [Infinity, Infinity, Infinity], high = [-1, -1, -1];
  for (let i = 0; i < points; ++i) {
    for (let axis = 0; axis < 3; ++axis) {
      const value = integers[3 * i + axis];
      if (got[6 * i + axis] !== value) ++wrong;
      low[axis] = Math.min(low[axis], value);
      high[axis] = Math.max(high[axis], value);
    }
    for (let axis = 0; normals && axis < 2; ++axis) {
      if (got[6 * i + 4 + axis] !== integers[3 * points + 2 * i + axis]) ++wrong;
    }
  }
  return wrong + [...low, ...high].filter((value, i) => value !== extent[i]).length;
}

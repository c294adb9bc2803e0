// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import createDecoderModule from 'draco3d/draco_decoder_nodejs.js';
import { extentOf, NUMBERS_PER_POINT, type ChunkForm, type DecodedChunk } from './chunk_form';
import { DracoChunkDecoder } from './draco_chunk';

/** Decodes chunks of every encoding; one per worker. */
export class ChunkDecoder {
  private constructor(private readonly draco: DracoChunkDecoder) {}

  /** @param wasm draco_decoder.wasm of draco3d. */
  static async create(wasm: ArrayBuffer): Promise<ChunkDecoder> {
    return new ChunkDecoder(new DracoChunkDecoder(await createDecoderModule({ wasmBinary: wasm })));
  }

  /** @param reuse Memory for the points, used if it is large enough. */
  decode(data: Uint8Array, form: ChunkForm, reuse?: ArrayBuffer): DecodedChunk {
    const numbers = NUMBERS_PER_POINT * form.points;
    const bytes = numbers * (form.encoding === 'raw' ? 4 : 2);
    const memory = reuse && reuse.byteLength >= bytes ? reuse : new ArrayBuffer(bytes);
    if (form.encoding === 'raw') {
      const points = new Float32Array(memory, 0, numbers);
      readRaw(data, form, points);
      return { points, extent: extentOf(points, form.points) };
    }
    const points = new Uint16Array(memory, 0, numbers);
    if (form.encoding === 'draco') this.draco.decode(data, form, points);
    else readQuantised(data, form, points);
    return { points, extent: extentOf(points, form.points) };
  }
}

/** Reads ENCODING_RAW (float32, interleaved) into x y z nx ny nz of each point. Throws if the length differs. */
function readRaw(data: Uint8Array, form: ChunkForm, out: Float32Array): void {
  const numbers = form.normals ? 6 : 3;
  const expected = 4 * numbers * form.points;
  if (data.length !== expected) throw new Error(`a raw chunk of ${data.length} bytes, not ${expected}`);
  if (form.normals) {
    new Uint8Array(out.buffer, out.byteOffset, expected).set(data);
    return;
  }
  const bytes = data.byteOffset % 4 === 0 ? data : data.slice();
  const values = new Float32Array(bytes.buffer, bytes.byteOffset, 3 * form.points);
  for (let i = 0; i < form.points; ++i) {
    out.set(values.subarray(3 * i, 3 * i + 3), NUMBERS_PER_POINT * i);
  }
}

/** Reads ENCODING_QUANTISED (little endian, planar) into x y z 0 s t of each point. Throws if the length differs. */
function readQuantised(data: Uint8Array, form: ChunkForm, out: Uint16Array): void {
  const { points, normals } = form;
  const wide = form.normalBits > 8;
  const expected = 6 * points + (normals ? 2 * points * (wide ? 2 : 1) : 0);
  if (data.length !== expected) throw new Error(`a quantised chunk of ${data.length} bytes, not ${expected}`);
  // Browsers run on little-endian machines only. Bytes at an odd address are copied.
  const bytes = data.byteOffset % 2 === 0 ? data : data.slice();
  for (let axis = 0; axis < 3; ++axis) {
    scatter(new Uint16Array(bytes.buffer, bytes.byteOffset + 2 * axis * points, points), out, axis);
  }
  if (!normals) return;
  const begin = bytes.byteOffset + 6 * points;
  for (let axis = 0; axis < 2; ++axis) {
    const plane = wide ? new Uint16Array(bytes.buffer, begin + 2 * axis * points, points)
                       : new Uint8Array(bytes.buffer, begin + axis * points, points);
    scatter(plane, out, 4 + axis);
  }
}

function scatter(plane: Uint16Array | Uint8Array, out: Uint16Array, place: number): void {
  for (let i = 0, at = place; i < plane.length; ++i, at += NUMBERS_PER_POINT) out[at] = plane[i]!;
}

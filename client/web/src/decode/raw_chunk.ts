// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { NUMBERS_PER_POINT, type ChunkForm } from './chunk_form';

/** Reads ENCODING_RAW (float32, interleaved) into x y z nx ny nz of each point. Throws where lengths differ. */
export function readRaw(data: Uint8Array, form: ChunkForm, out: Float32Array): void {
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

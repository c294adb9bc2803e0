// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { NUMBERS_PER_POINT, type ChunkForm } from './chunk_form';

/** Reads ENCODING_QUANTISED (little endian, planar) into x y z 0 s t of each point. Throws where lengths differ. */
export function readQuantised(data: Uint8Array, form: ChunkForm, out: Uint16Array): void {
  const { points, normals } = form;
  const wide = form.normalBits > 8;
  const expected = 6 * points + (normals ? 2 * points * (wide ? 2 : 1) : 0);
  if (data.length !== expected) throw new Error(`a quantised chunk of ${data.length} bytes, not ${expected}`);
  // Little endian as all that browsers run on; a copy where the bytes lie at an odd address.
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

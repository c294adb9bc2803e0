// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Form of a chunk's bytes (view.proto, Encoding) and how many points they hold. */
export interface ChunkForm {
  readonly encoding: 'draco' | 'meshopt' | 'quantised' | 'raw';
  readonly points: number;
  /** Whether normals are sent. */
  readonly normals: boolean;
  /** Bits per coordinate of positions; 0 if they are floats. */
  readonly positionBits: number;
  /** Bits per coordinate of the octahedral normals. */
  readonly normalBits: number;
}

/** Numbers of a point in decoded chunks: x y z 0 s t of integers, or x y z nx ny nz of floats. */
export const NUMBERS_PER_POINT = 6;

/** Points of one chunk: six integers each, or six floats for RAW. */
export type PointNumbers = Uint16Array | Float32Array;

/** A chunk to decode. */
export interface ChunkData {
  readonly data: Uint8Array;
  readonly form: ChunkForm;
}

export interface DecodedChunk {
  readonly points: PointNumbers;
  /** min x y z, max x y z of the numbers in `points`. */
  readonly extent: Float32Array;
}

/** min x y z, max x y z over all points; infinities if there are none. */
export function extentOf(points: PointNumbers, count: number): Float32Array {
  const extent = new Float32Array([Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity]);
  for (let axis = 0; axis < 3; ++axis) {
    let low = Infinity;
    let high = -Infinity;
    for (let i = axis, end = NUMBERS_PER_POINT * count; i < end; i += NUMBERS_PER_POINT) {
      const value = points[i]!;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    extent[axis] = low;
    extent[3 + axis] = high;
  }
  return extent;
}

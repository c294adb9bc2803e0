// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decodes chunks of ENCODING_DRACO_POINTS to arrays: by decoder.wasm, and by draco3d streams that it refuses, or all where
// generate.mjs found no decoder.wasm.
import { existsSync, readFileSync } from 'node:fs';
import { OwnDecoder } from './own_decoder.js';
import type { StockDecoder } from './stock_decoder.js';

export interface EncodedChunk {
  data: Uint8Array;
  points: number;
}

/** The part of the message Quantisation that decoding needs. */
export interface Grid {
  step: number;
  bits: number;
  normalBits: number;  // 0 if the view has no normals
}

export interface Points {
  positions: Float32Array;  // x y z of each point, relative to Quantisation.origin
  normals: Float32Array;    // x y z of each, unit vectors; empty if the view has none
}

const BATCH = 16;  // chunks: enough to be fast, and few enough for the cache
const WASM = new URL('../decoder.wasm', import.meta.url);

export class DracoPoints {
  private stock: Promise<StockDecoder> | undefined;

  /** @param loadStock Loads draco3d when a stream needs it. */
  constructor(private readonly own: OwnDecoder | undefined, private readonly loadStock: () => Promise<StockDecoder>) {}

  static async create(): Promise<DracoPoints> {
    return new DracoPoints(existsSync(WASM) ? await OwnDecoder.create(new Uint8Array(readFileSync(WASM))) : undefined,
      async () => (await import('./stock_decoder.js')).StockDecoder.create());
  }

  /** Throws if a chunk is no Draco point cloud of so many points. */
  async decode(chunks: readonly EncodedChunk[], grid: Grid): Promise<Points[]> {
    const decoded: Points[] = [];
    for (let first = 0; first < chunks.length; first += BATCH) {
      const batch = chunks.slice(first, first + BATCH);
      const ours = this.own?.decode(batch, grid) ?? [];
      for (const [i, chunk] of batch.entries()) {
        decoded.push(toPoints(ours[i] ?? await this.decodeByStock(chunk, grid), grid));
      }
    }
    return decoded;
  }

  private async decodeByStock(chunk: EncodedChunk, { normalBits }: Grid): Promise<Uint16Array> {
    this.stock ??= this.loadStock();
    return (await this.stock).decode(chunk, normalBits > 0);
  }
}

// What the integers x y z 0 s t of each point mean.
function toPoints(numbers: Uint16Array, { step, normalBits }: Grid): Points {
  const count = numbers.length / 6;
  const positions = new Float32Array(3 * count);
  const normals = new Float32Array(normalBits > 0 ? 3 * count : 0);
  for (let i = 0; i < count; ++i) {
    for (let axis = 0; axis < 3; ++axis) positions[3 * i + axis] = numbers[6 * i + axis]! * step;
    if (normalBits > 0) normals.set(octahedralNormal(numbers[6 * i + 4]!, numbers[6 * i + 5]!, normalBits), 3 * i);
  }
  return { positions, normals };
}

// The unit normal of s and t: view.proto, ENCODING_QUANTISED.
function octahedralNormal(s: number, t: number, bits: number): [number, number, number] {
  const most = 2 ** bits - 2;
  let y = 2 * s / most - 1, z = 2 * t / most - 1;
  const x = 1 - Math.abs(y) - Math.abs(z);
  if (x < 0) {
    y += y < 0 ? -x : x;
    z += z < 0 ? -x : x;
  }
  const length = Math.sqrt(x * x + y * y + z * z);
  return [x / length, y / length, z / length];
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { extentOf, NUMBERS_PER_POINT, type ChunkData, type ChunkForm, type DecodedChunk, type PointNumbers } from './chunk_form';
import type { DracoChunkDecoder } from './draco_chunk';
import { OwnDecoder } from './own_decoder';

/** The results of a batch, and the memory that its points lie in. */
export interface DecodedBatch {
  readonly memory: ArrayBuffer;
  readonly results: readonly (DecodedChunk | Error)[];
}

/** Decodes chunks of every encoding; one per worker. */
export class ChunkDecoder {
  private stock: Promise<DracoChunkDecoder> | undefined;

  private constructor(
    private readonly own: OwnDecoder | undefined,
    private readonly loadStock: () => Promise<DracoChunkDecoder>,
  ) {}

  /**
   * @param wasm decoder.wasm of client/decoder. Without it, and in a browser without SIMD128, draco3d decodes.
   * @param loadStock Loads draco3d when it is needed.
   */
  static async create(wasm: ArrayBuffer | undefined, loadStock: () => Promise<DracoChunkDecoder>): Promise<ChunkDecoder> {
    const own = wasm && WebAssembly.validate(wasm) ? await OwnDecoder.create(wasm) : undefined;
    return new ChunkDecoder(own, loadStock);
  }

  /**
   * Decodes chunks, the more at once the sooner. Their points lie in one piece of memory: `reuse`, if that is large enough. A chunk
   * that cannot be decoded has an error for a result.
   */
  async decode(chunks: readonly ChunkData[], reuse?: ArrayBuffer): Promise<DecodedBatch> {
    const { memory, arrays } = roomFor(chunks, reuse);
    const extents = this.own ? decodeByOwn(this.own, chunks, arrays) : new Map<number, Float32Array>();
    const results: (DecodedChunk | Error)[] = [];
    for (const [i, chunk] of chunks.entries()) {
      const points = arrays[i]!;
      const extent = extents.get(i) ?? await this.decodeAlone(chunk, points).catch((error: unknown) =>
        error instanceof Error ? error : new Error(String(error)));
      results.push(extent instanceof Error ? extent : { points, extent });
    }
    return { memory, results };
  }

  private async decodeAlone({ data, form }: ChunkData, points: PointNumbers): Promise<Float32Array> {
    if (points instanceof Float32Array) readRaw(data, form, points);
    else if (form.encoding === 'draco') (await this.stockDecoder()).decode(data, form, points);
    else if (form.encoding === 'meshopt') throw new Error(this.whyNotMeshopt);
    else readQuantised(data, form, points);
    return extentOf(points, form.points);
  }

  private get whyNotMeshopt(): string {
    return this.own ? 'a chunk is no meshopt stream of its view' : 'this browser has no WebAssembly SIMD, which meshopt chunks need';
  }

  /** draco3d, loaded once. A failed attempt is repeated with the next chunk. */
  private stockDecoder(): Promise<DracoChunkDecoder> {
    this.stock ??= this.loadStock();
    this.stock.catch(() => (this.stock = undefined));
    return this.stock;
  }
}

/** An array for the points of each chunk, all in one piece of memory. */
function roomFor(chunks: readonly ChunkData[], reuse: ArrayBuffer | undefined): { memory: ArrayBuffer; arrays: PointNumbers[] } {
  const numbers = chunks.map(({ form }) => NUMBERS_PER_POINT * form.points);
  const begins: number[] = [];
  let end = 0;
  for (const [i, { form }] of chunks.entries()) {
    begins.push(end);
    end += numbers[i]! * (form.encoding === 'raw' ? 4 : 2);
  }
  const memory = reuse && reuse.byteLength >= end ? reuse : new ArrayBuffer(end);
  const arrays = chunks.map(({ form }, i) => form.encoding === 'raw' ? new Float32Array(memory, begins[i], numbers[i])
                                                                     : new Uint16Array(memory, begins[i], numbers[i]));
  return { memory, arrays };
}

/** Decodes those chunks that our decoder knows. Returns the extent of each by its place. */
function decodeByOwn(own: OwnDecoder, chunks: readonly ChunkData[], arrays: readonly PointNumbers[]): Map<number, Float32Array> {
  const byBits = new Map<string, number[]>();
  for (const [i, { form: { encoding, positionBits, normals, normalBits } }] of chunks.entries()) {
    if (encoding !== 'draco' && encoding !== 'meshopt') continue;
    const bits = `${encoding}/${positionBits}/${normals ? normalBits : 0}`;
    const group = byBits.get(bits);
    if (group) group.push(i);
    else byBits.set(bits, [i]);
  }
  const extents = new Map<number, Float32Array>();
  for (const group of byBits.values()) {
    const decoded = own.decode(group.map((i) => chunks[i]!), group.map((i) => arrays[i] as Uint16Array));
    decoded.forEach((extent, at) => extent && extents.set(group[at]!, extent));
  }
  return extents;
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

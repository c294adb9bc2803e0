// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { extentOf, NUMBERS_PER_POINT, pointMemory, type ChunkForm, type DecodedChunk } from './chunk_form';
import type { DracoChunkDecoder } from './draco_chunk';
import { OwnDecoder, type ChunkData } from './own_decoder';

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

  /** Decodes chunks, the sooner the more they are. A chunk that cannot be decoded has an error for a result. */
  async decode(chunks: readonly ChunkData[]): Promise<(DecodedChunk | Error)[]> {
    const results = this.own ? decodeByOwn(this.own, chunks) : new Map<ChunkData, DecodedChunk>();
    const decoded: (DecodedChunk | Error)[] = [];
    for (const chunk of chunks) {
      decoded.push(results.get(chunk) ?? await this.decodeAlone(chunk).catch((error: unknown) =>
        error instanceof Error ? error : new Error(String(error))));
    }
    return decoded;
  }

  private async decodeAlone({ data, form, reuse }: ChunkData): Promise<DecodedChunk> {
    const numbers = NUMBERS_PER_POINT * form.points;
    const memory = pointMemory(numbers * (form.encoding === 'raw' ? 4 : 2), reuse);
    const points = form.encoding === 'raw' ? new Float32Array(memory, 0, numbers) : new Uint16Array(memory, 0, numbers);
    if (points instanceof Float32Array) readRaw(data, form, points);
    else if (form.encoding === 'draco') (await this.stockDecoder()).decode(data, form, points);
    else readQuantised(data, form, points);
    return { points, extent: extentOf(points, form.points) };
  }

  /** draco3d, loaded once. A failed attempt is repeated with the next chunk. */
  private stockDecoder(): Promise<DracoChunkDecoder> {
    this.stock ??= this.loadStock();
    this.stock.catch(() => (this.stock = undefined));
    return this.stock;
  }
}

/** Decodes those Draco chunks that our decoder knows. */
function decodeByOwn(own: OwnDecoder, chunks: readonly ChunkData[]): Map<ChunkData, DecodedChunk> {
  const byBits = new Map<string, ChunkData[]>();
  for (const chunk of chunks) {
    const { encoding, positionBits, normals, normalBits } = chunk.form;
    if (encoding !== 'draco') continue;
    const bits = `${positionBits}/${normals ? normalBits : 0}`;
    const group = byBits.get(bits);
    if (group) group.push(chunk);
    else byBits.set(bits, [chunk]);
  }
  const results = new Map<ChunkData, DecodedChunk>();
  for (const group of byBits.values()) {
    own.decode(group).forEach((result, i) => result && results.set(group[i]!, result));
  }
  return results;
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

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { NUMBERS_PER_POINT, pointMemory, type ChunkForm, type DecodedChunk } from './chunk_form';

/** A chunk to decode, and memory for its points, used if it is large enough. */
export interface ChunkData {
  readonly data: Uint8Array;
  readonly form: ChunkForm;
  readonly reuse?: ArrayBuffer | undefined;
}

/** What client/decoder/wasm/module.cc exports. */
interface DecoderModule {
  readonly memory: WebAssembly.Memory;
  Reserve(bytes: number): number;
  Decode(records: number, count: number, positionBits: number, normalBits: number): void;
}

/** The place of a chunk's record, stream and points in the module's memory, from the reserved address on. */
interface Place {
  readonly record: number;
  readonly stream: number;
  readonly points: number;
}

/** Decodes the Draco streams that latticed writes, several times faster than draco3d: client/decoder as WebAssembly. */
export class OwnDecoder {
  private static readonly RECORD_BYTES = 32;

  private constructor(private readonly module: DecoderModule) {}

  /** Fails in a browser without SIMD128. */
  static async create(wasm: ArrayBuffer): Promise<OwnDecoder> {
    const { instance } = await WebAssembly.instantiate(wasm);
    return new OwnDecoder(instance.exports as unknown as DecoderModule);
  }

  /** Returns a result for each chunk; undefined for streams that latticed does not write. All have the same bits. */
  decode(chunks: readonly ChunkData[]): (DecodedChunk | undefined)[] {
    const { module } = this;
    let end = OwnDecoder.RECORD_BYTES * chunks.length;
    const take = (bytes: number): number => {
      const begin = end;
      end += Math.ceil(bytes / 4) * 4;
      return begin;
    };
    const places = chunks.map(({ data, form }, i): Place =>
      ({ record: OwnDecoder.RECORD_BYTES * i, stream: take(data.length), points: take(2 * NUMBERS_PER_POINT * form.points) }));
    const start = module.Reserve(end);
    const bytes = new Uint8Array(module.memory.buffer, start, end);
    const records = new Uint32Array(module.memory.buffer, start, end / 4);
    chunks.forEach(({ data, form }, i) => {
      const { record, stream, points } = places[i]!;
      records.set([start + stream, data.length, form.points, start + points], record / 4);
      bytes.set(data, stream);
    });
    const { positionBits, normals, normalBits } = chunks[0]!.form;
    module.Decode(start, chunks.length, positionBits, normals ? normalBits : 0);
    return chunks.map((chunk, i) => this.read(chunk, start, places[i]!));
  }

  private read({ form, reuse }: ChunkData, start: number, place: Place): DecodedChunk | undefined {
    const { buffer } = this.module.memory;  // replaced when memory grew
    if (new Uint32Array(buffer, start + place.record, 5)[4] === 0) return undefined;
    const numbers = NUMBERS_PER_POINT * form.points;
    const points = new Uint16Array(pointMemory(2 * numbers, reuse), 0, numbers);
    points.set(new Uint16Array(buffer, start + place.points, numbers));
    return { points, extent: Float32Array.from(new Uint16Array(buffer, start + place.record + 20, 6)) };
  }
}

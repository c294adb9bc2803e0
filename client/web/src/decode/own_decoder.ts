// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { NUMBERS_PER_POINT, type ChunkData } from './chunk_form';

/** What client/decoder/wasm/module.cc exports. */
interface DecoderModule {
  readonly memory: WebAssembly.Memory;
  Reserve(bytes: number): number;
  Decode(records: number, count: number, codec: number, positionBits: number, normalBits: number): void;
}

/** The place of a chunk's record, stream and points in the module's memory, from the reserved address on. */
interface Place {
  readonly record: number;
  readonly stream: number;
  readonly points: number;
}

/** Codec of client/decoder/chunk_decoder.h. */
const CODECS = { draco: 0, meshopt: 1 } as const;

/** Decodes the Draco and meshopt streams that latticed writes, several times faster than draco3d: client/decoder as WebAssembly. */
export class OwnDecoder {
  private static readonly RECORD_BYTES = 32;

  private constructor(private readonly module: DecoderModule) {}

  /** Fails in a browser without SIMD128. */
  static async create(wasm: ArrayBuffer): Promise<OwnDecoder> {
    const { instance } = await WebAssembly.instantiate(wasm);
    return new OwnDecoder(instance.exports as unknown as DecoderModule);
  }

  /**
   * Decodes chunks of the same codec and bits. Writes the points of each to its array, and returns its extent; undefined, and nothing
   * written, for a stream that latticed does not write.
   */
  decode(chunks: readonly ChunkData[], out: readonly Uint16Array[]): (Float32Array | undefined)[] {
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
    const { encoding, positionBits, normals, normalBits } = chunks[0]!.form;
    module.Decode(start, chunks.length, CODECS[encoding as keyof typeof CODECS], positionBits, normals ? normalBits : 0);
    const { buffer } = module.memory;  // replaced when memory grew
    return places.map(({ record, points }, i) => {
      if (new Uint32Array(buffer, start + record, 5)[4] === 0) return undefined;
      out[i]!.set(new Uint16Array(buffer, start + points, out[i]!.length));
      return new Float32Array(new Uint16Array(buffer, start + record + 20, 6));
    });
  }
}

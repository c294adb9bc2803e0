// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// client/decoder as WebAssembly: decodes the Draco streams that latticed writes, several times faster than draco3d.
import type { EncodedChunk, Grid } from './draco_points.js';

// What client/decoder/wasm/module.cc exports. A record is eight uint32: address and bytes of the stream, number of points, and
// address of the points; then whether they were decoded, and their extent.
interface DecoderModule {
  memory: WebAssembly.Memory;
  Reserve(bytes: number): number;
  Decode(records: number, count: number, codec: number, positionBits: number, normalBits: number): void;
}
const RECORD = 8, DECODED = 4;  // numbers
const DRACO = 0;  // a codec; the module decodes meshopt too

export class OwnDecoder {
  private constructor(private readonly module: DecoderModule) {}

  static async create(wasm: Uint8Array<ArrayBuffer>): Promise<OwnDecoder> {
    const { exports } = new WebAssembly.Instance(await WebAssembly.compile(wasm));
    return new OwnDecoder(exports as unknown as DecoderModule);
  }

  /** x y z 0 s t of each chunk's points; undefined for a stream that latticed does not write. Fastest with eight chunks or more. */
  decode(chunks: readonly EncodedChunk[], { bits, normalBits }: Grid): (Uint16Array | undefined)[] {
    let end = 4 * RECORD * chunks.length;
    const take = (bytes: number): number => {
      const begin = end;
      end += Math.ceil(bytes / 4) * 4;
      return begin;
    };
    const places = chunks.map(({ data, points }) => ({ stream: take(data.length), points: take(12 * points) }));
    const start = this.module.Reserve(end);
    const { buffer } = this.module.memory;  // another one whenever memory has grown
    chunks.forEach(({ data, points }, i) => {
      const place = places[i]!;
      new Uint32Array(buffer, start + 4 * RECORD * i, RECORD).set([start + place.stream, data.length, points, start + place.points]);
      new Uint8Array(buffer, start + place.stream, data.length).set(data);
    });
    this.module.Decode(start, chunks.length, DRACO, bits, normalBits);
    const records = new Uint32Array(this.module.memory.buffer, start, RECORD * chunks.length);
    return chunks.map(({ points }, i) => records[RECORD * i + DECODED] === 0 ? undefined
      : new Uint16Array(this.module.memory.buffer, start + places[i]!.points, 6 * points).slice());
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import createDecoderModule from 'draco3d/draco_decoder_nodejs.js';
import { extentOf, NUMBERS_PER_POINT, type ChunkForm, type DecodedChunk } from './chunk_form';
import { DracoChunkDecoder } from './draco_chunk';
import { readQuantised } from './quantised_chunk';
import { readRaw } from './raw_chunk';

/** Decodes chunks of every encoding; one per worker. */
export class ChunkDecoder {
  private constructor(private readonly draco: DracoChunkDecoder) {}

  /** @param wasm draco_decoder.wasm of draco3d. */
  static async create(wasm: ArrayBuffer): Promise<ChunkDecoder> {
    return new ChunkDecoder(new DracoChunkDecoder(await createDecoderModule({ wasmBinary: wasm })));
  }

  /** @param reuse Memory for the points where it is large enough. */
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

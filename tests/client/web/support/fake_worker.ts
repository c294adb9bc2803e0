// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { readFileSync } from 'node:fs';
import { answerBatch } from '@src/decode/answer_batch';
import { ChunkDecoder } from '@src/decode/chunk_decoder';
import { DecodePool, type DecodeAnswer, type DecodeBatch, type DecodeRequest, type DecodeWorker } from '@src/decode/decode_pool';
import { DracoChunkDecoder } from '@src/decode/draco_chunk';

const bytesOf = (path: string): ArrayBuffer => new Uint8Array(readFileSync(path)).buffer;
/** Environment: LATTICED_DECODER_WASM, the module of client/decoder; without it draco3d decodes. */
export const decoderWasm = process.env.LATTICED_DECODER_WASM ? bytesOf(process.env.LATTICED_DECODER_WASM) : undefined;
const draco3dWasm = bytesOf('node_modules/draco3d/draco_decoder.wasm');
export const loadDraco3d = (): Promise<DracoChunkDecoder> => DracoChunkDecoder.create(draco3dWasm);

/** A pool of such workers. */
export function poolOf(...workers: readonly FakeWorker[]): DecodePool {
  return new DecodePool(workers, decoderWasm, { script: 'draco_chunk.js', wasm: 'draco_decoder.wasm' });
}

/** A worker that decodes when work() is called, or at once. */
export class FakeWorker implements DecodeWorker {
  onmessage: ((event: { data: DecodeAnswer }) => void) | null = null;
  onerror: ((event: { message?: string }) => void) | null = null;
  readonly batches: DecodeBatch[] = [];

  constructor(private readonly atOnce = false, private readonly decoder = FakeWorker.sharedDecoder()) {}

  private static shared: Promise<ChunkDecoder> | undefined;  // compiling draco3d takes long
  private static sharedDecoder(): Promise<ChunkDecoder> {
    return (FakeWorker.shared ??= ChunkDecoder.create(decoderWasm, loadDraco3d));
  }

  postMessage(message: DecodeRequest): void {
    if (message.kind !== 'batch') return;
    this.batches.push(message);
    if (this.atOnce) void this.work();
  }

  /** Decodes all waiting batches, in order. */
  async work(): Promise<void> {
    for (const batch of this.batches.splice(0)) this.onmessage?.({ data: await answerBatch(batch, this.decoder) });
  }

  terminate(): void {}
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { ChunkDecoder } from '@src/decode/chunk_decoder';
import type { DecodeAnswer, DecodeBatch, DecodeRequest, DecodeWorker } from '@src/decode/decode_pool';

/** A worker that decodes when work() is called, or at once. */
export class FakeWorker implements DecodeWorker {
  onmessage: ((event: { data: readonly DecodeAnswer[] }) => void) | null = null;
  onerror: ((event: { message?: string }) => void) | null = null;
  readonly batches: DecodeBatch[] = [];
  private readonly decoder: Promise<ChunkDecoder>;

  constructor(wasm: ArrayBuffer, private readonly atOnce = false) {
    this.decoder = FakeWorker.shared ??= ChunkDecoder.create(wasm);
  }

  private static shared: Promise<ChunkDecoder> | undefined;  // compiling the decoder takes long

  postMessage(message: DecodeRequest): void {
    if (message.kind !== 'batch') return;
    this.batches.push(message);
    if (this.atOnce) void this.work();
  }

  /** Decodes all waiting batches, in order. */
  async work(): Promise<void> {
    const decoder = await this.decoder;
    for (const { jobs } of this.batches.splice(0)) {
      this.onmessage?.({ data: jobs.map(({ id, data, form, reuse }): DecodeAnswer => {
        try {
          return { id, chunk: decoder.decode(data, form, reuse) };
        } catch (error) {
          return { id, error: (error as Error).message };
        }
      }) });
    }
  }

  terminate(): void {}
}

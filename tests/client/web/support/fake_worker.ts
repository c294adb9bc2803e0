// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { ChunkDecoder } from '@src/decode/chunk_decoder';
import type { DecodeAnswer, DecodeJob, DecodeRequest, DecodeWorker } from '@src/decode/decode_pool';

/** A worker that decodes when work() is called, or at once. */
export class FakeWorker implements DecodeWorker {
  onmessage: ((event: { data: DecodeAnswer }) => void) | null = null;
  onerror: ((event: { message?: string }) => void) | null = null;
  readonly jobs: DecodeJob[] = [];
  private readonly decoder: Promise<ChunkDecoder>;

  constructor(wasm: ArrayBuffer, private readonly atOnce = false) {
    this.decoder = FakeWorker.shared ??= ChunkDecoder.create(wasm);
  }

  private static shared: Promise<ChunkDecoder> | undefined;  // compiling the decoder takes long

  postMessage(message: DecodeRequest): void {
    if (message.kind !== 'job') return;
    this.jobs.push(message);
    if (this.atOnce) void this.work();
  }

  /** Decodes all waiting jobs, in order. */
  async work(): Promise<void> {
    const decoder = await this.decoder;
    for (const job of this.jobs.splice(0)) {
      let answer: DecodeAnswer;
      try {
        answer = { id: job.id, chunk: decoder.decode(job.data, job.form, job.reuse) };
      } catch (error) {
        answer = { id: job.id, error: (error as Error).message };
      }
      this.onmessage?.({ data: answer });
    }
  }

  terminate(): void {}
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { ChunkDecoder } from './chunk_decoder';
import type { DecodeAnswer, DecodeJob, DecodeRequest } from './decode_pool';

/** The worker's side: decodes jobs in the order of arrival. */
const worker = globalThis as unknown as {
  onmessage: (event: MessageEvent<DecodeRequest>) => void;
  postMessage(answer: DecodeAnswer, transfer: ArrayBuffer[]): void;
};
let decoder: Promise<ChunkDecoder> | undefined;

async function answer({ id, data, form, reuse }: DecodeJob): Promise<void> {
  try {
    if (!decoder) throw new Error('a job before the start');
    const chunk = (await decoder).decode(data, form, reuse);
    worker.postMessage({ id, chunk }, [chunk.points.buffer as ArrayBuffer]);
  } catch (error) {
    worker.postMessage({ id, error: error instanceof Error ? error.message : String(error) }, []);
  }
}

worker.onmessage = ({ data }) => {
  if (data.kind === 'start') decoder = ChunkDecoder.create(data.wasm);
  else void answer(data);
};

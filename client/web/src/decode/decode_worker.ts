// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { ChunkDecoder } from './chunk_decoder';
import type { DecodeAnswer, DecodeBatch, DecodeRequest } from './decode_pool';

/** The worker's side: decodes batches in the order of arrival. */
const worker = globalThis as unknown as {
  onmessage: (event: MessageEvent<DecodeRequest>) => void;
  postMessage(answers: DecodeAnswer[], transfer: ArrayBuffer[]): void;
};
let decoder: Promise<ChunkDecoder> | undefined;

async function answer({ jobs }: DecodeBatch): Promise<void> {
  const answers: DecodeAnswer[] = [];
  for (const { id, data, form, reuse } of jobs) {
    try {
      if (!decoder) throw new Error('a job before the start');
      answers.push({ id, chunk: (await decoder).decode(data, form, reuse) });
    } catch (error) {
      answers.push({ id, error: error instanceof Error ? error.message : String(error) });
    }
  }
  worker.postMessage(answers, answers.flatMap(({ chunk }) => (chunk ? [chunk.points.buffer as ArrayBuffer] : [])));
}

worker.onmessage = ({ data }) => {
  if (data.kind === 'start') decoder = ChunkDecoder.create(data.wasm);
  else void answer(data);
};

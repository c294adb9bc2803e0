// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { answerBatch } from './answer_batch';
import { ChunkDecoder } from './chunk_decoder';
import type { DecodeAnswer, DecodeBatch, DecodeRequest, DecodeStart } from './decode_pool';
import type { DracoChunkDecoder } from './draco_chunk';

/** The worker's side: decodes batches. */
const worker = globalThis as unknown as {
  onmessage: (event: MessageEvent<DecodeRequest>) => void;
  postMessage(answer: DecodeAnswer, transfer: ArrayBuffer[]): void;
};
let decoder: Promise<ChunkDecoder> = Promise.reject(new Error('a job before the start'));
decoder.catch(() => undefined);

async function loadDraco3d({ script, wasm }: DecodeStart['draco3d']): Promise<DracoChunkDecoder> {
  const response = await fetch(wasm);
  if (!response.ok) throw new Error(`${wasm} cannot be fetched: ${response.status}`);
  const { DracoChunkDecoder: Decoder } = await import(script) as typeof import('./draco_chunk');
  return Decoder.create(await response.arrayBuffer());
}

async function answer(batch: DecodeBatch): Promise<void> {
  const answered = await answerBatch(batch, decoder);
  worker.postMessage(answered, [answered.memory]);
}

worker.onmessage = ({ data }) => {
  if (data.kind === 'start') decoder = ChunkDecoder.create(data.wasm, () => loadDraco3d(data.draco3d));
  else void answer(data);
};

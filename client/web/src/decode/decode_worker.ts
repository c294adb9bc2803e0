// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { ChunkDecoder } from './chunk_decoder';
import type { DecodeAnswer, DecodeBatch, DecodeRequest, DecodeStart } from './decode_pool';
import type { DracoChunkDecoder } from './draco_chunk';

/** The worker's side: decodes batches. */
const worker = globalThis as unknown as {
  onmessage: (event: MessageEvent<DecodeRequest>) => void;
  postMessage(answers: DecodeAnswer[], transfer: ArrayBuffer[]): void;
};
let decoder: Promise<ChunkDecoder> = Promise.reject(new Error('a job before the start'));
decoder.catch(() => undefined);

async function loadDraco3d({ script, wasm }: DecodeStart['draco3d']): Promise<DracoChunkDecoder> {
  const response = await fetch(wasm);
  if (!response.ok) throw new Error(`${wasm} cannot be fetched: ${response.status}`);
  const { DracoChunkDecoder: Decoder } = await import(script) as typeof import('./draco_chunk');
  return Decoder.create(await response.arrayBuffer());
}

async function answer({ jobs }: DecodeBatch): Promise<void> {
  const results = await decoder.then((ready) => ready.decode(jobs), (error: unknown) => jobs.map(() => new Error(String(error))));
  const answers = results.map((result, i): DecodeAnswer =>
    result instanceof Error ? { id: jobs[i]!.id, error: result.message } : { id: jobs[i]!.id, chunk: result });
  worker.postMessage(answers, answers.flatMap(({ chunk }) => (chunk ? [chunk.points.buffer as ArrayBuffer] : [])));
}

worker.onmessage = ({ data }) => {
  if (data.kind === 'start') decoder = ChunkDecoder.create(data.wasm, () => loadDraco3d(data.draco3d));
  else void answer(data);
};

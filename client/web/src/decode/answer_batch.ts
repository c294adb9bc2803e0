// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ChunkDecoder } from './chunk_decoder';
import type { ChunkData } from './chunk_form';
import type { DecodeAnswer, DecodeBatch } from './decode_pool';

/** Decodes a batch. If the decoder cannot be made, or fails, each chunk is answered with the error. */
export async function answerBatch({ id, data, chunks, reuse }: DecodeBatch, decoder: Promise<ChunkDecoder>): Promise<DecodeAnswer> {
  let end = 0;
  const parts = chunks.map(({ bytes, form }): ChunkData => ({ form, data: data.subarray(end, (end += bytes)) }));
  await decoder.catch(() => undefined);
  const begin = performance.now();
  const { memory, results } = await decoder.then((ready) => ready.decode(parts, reuse)).catch(
    (error: unknown) => ({ memory: new ArrayBuffer(0), results: chunks.map(() => new Error(String(error))) }));
  const ms = performance.now() - begin;
  return { id, memory, ms, chunks: results.map((result) => (result instanceof Error ? result.message : result)) };
}

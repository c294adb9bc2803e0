// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures in Chromium how long the points of one update take: by draco3d and by our decoder, in the loop that each worker of the
// viewer runs, and through the viewer's pool, from the chunks in the page to their points in the page.
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import { ChunkDecoder } from '@src/decode/chunk_decoder';
import type { ChunkData, DecodedChunk } from '@src/decode/chunk_form';
import { DecodePool, type DecodeWorker } from '@src/decode/decode_pool';
import { TopologyLayout } from '@src/surface/topology_layout';
import { fetchAsset } from '@src/wire/asset';
import { LatticedServer } from '@src/wire/latticed_server';

/** build.mjs defines it, as for decode_pool.ts. */
declare const DECODER_FILES: {
  readonly worker: string; readonly wasm: string | undefined; readonly draco3d: { readonly script: string; readonly wasm: string };
};

export interface DecodeTimes {
  readonly chunks: number;
  readonly points: number;
  readonly bytes: number;
  /** Chunks whose points are not those of draco3d. */
  readonly differing: number;
  /** Milliseconds of each round, in the order of WAYS. */
  readonly times: readonly number[][];
}

export const WAYS = ['draco3d, loop', 'ours, loop', 'draco3d, one worker', 'ours, one worker', 'ours, two workers'] as const;

/** Decodes the update. The points are valid until the next call, which uses their memory again. */
type Way = () => Promise<readonly DecodedChunk[]>;

const BATCH = 16; // chunks, as the pool's batches of 10 segments
const VIEW = { segments: 10, normals: NormalMode.SMOOTH, encoding: Encoding.DRACO_POINTS, positionBits: 12, normalBits: 8 };

/** The chunks of one update of the whole scene. */
async function chunksOf(scene: string): Promise<ChunkData[]> {
  const chunks: ChunkData[] = [];
  let layout: TopologyLayout | undefined;
  for await (const { event } of new LatticedServer(location.origin).scenes.getUpdate({ scene, view: VIEW })) {
    if (event.case === 'topology') layout = new TopologyLayout(event.value);
    if (event.case !== 'chunks') continue;
    for (const { index, data } of event.value.chunks) {
      const points = layout!.pointsOf(index, new Uint16Array());
      chunks.push({ data, form: { encoding: 'draco', points, normals: true, positionBits: VIEW.positionBits, normalBits: VIEW.normalBits } });
    }
  }
  return chunks;
}

const address = (name: string): string => new URL(name, import.meta.url).href;

/** The loop of a worker, in the page's thread. Without `wasm` draco3d decodes. */
async function loopOf(chunks: readonly ChunkData[], wasm?: ArrayBuffer): Promise<Way> {
  const decoder = await ChunkDecoder.create(wasm, async () => {
    const { DracoChunkDecoder } = await import(address(DECODER_FILES.draco3d.script)) as typeof import('@src/decode/draco_chunk');
    return DracoChunkDecoder.create(await (await fetchAsset(DECODER_FILES.draco3d.wasm)).arrayBuffer());
  });
  const batches = Array.from({ length: Math.ceil(chunks.length / BATCH) }, (_, i) => chunks.slice(BATCH * i, BATCH * (i + 1)));
  const kept: ArrayBuffer[] = [];
  return async () => {
    const decoded: DecodedChunk[] = [];
    for (const [i, batch] of batches.entries()) {
      const { memory, results } = await decoder.decode(batch, kept[i]);
      kept[i] = memory;
      decoded.push(...results as DecodedChunk[]);
    }
    return decoded;
  };
}

function poolOf(chunks: readonly ChunkData[], count: number, wasm?: ArrayBuffer): Way {
  const { worker, draco3d } = DECODER_FILES;
  const workers = Array.from({ length: count }, () => new Worker(address(worker), { type: 'module' }) as unknown as DecodeWorker);
  const pool = new DecodePool(workers, wasm, { script: address(draco3d.script), wasm: address(draco3d.wasm) });
  let held: readonly DecodedChunk[] = [];
  return async () => {
    for (const chunk of held) pool.giveBack(chunk);
    return (held = await Promise.all(chunks.map(({ data, form }) => pool.decode(data as Uint8Array<ArrayBuffer>, form).result)));
  };
}

/** Compares the points, which also loads all decoders; then measures rounds, in which the ways take turns. */
export async function measureDecode(scene: string, rounds: number): Promise<DecodeTimes> {
  const chunks = await chunksOf(scene);
  const wasm = await (await fetchAsset(DECODER_FILES.wasm!)).arrayBuffer();
  const ways = [await loopOf(chunks), await loopOf(chunks, wasm), poolOf(chunks, 1), poolOf(chunks, 1, wasm), poolOf(chunks, 2, wasm)];
  const [expected, ...others] = await Promise.all(ways.map((way) => way()));
  const differing = others.flatMap((decoded) =>
    decoded.filter(({ points }, i) => points.some((value, at) => value !== expected[i].points[at]))).length;

  const times = ways.map((): number[] => []);
  for (let round = 0; round < rounds; ++round) {
    for (const [i, way] of ways.entries()) {
      const begin = performance.now();
      await way();
      times[i].push(performance.now() - begin);
    }
  }
  const sum = (of: (chunk: ChunkData) => number): number => chunks.reduce((total, chunk) => total + of(chunk), 0);
  return { chunks: chunks.length, points: sum(({ form }) => form.points), bytes: sum(({ data }) => data.length), differing, times };
}

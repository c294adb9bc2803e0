// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which encoding of points suits the line and this page's workers (client/README.md, "Encodings").
import { Encoding } from 'latticed/v1/view_pb';
import type { ServerInfo } from 'latticed/v1/server_pb';
import type { DecodePool } from '../decode/decode_pool';
import type { LatticedServer } from '../wire/latticed_server';

const MORE_BYTES = 0.2; // of a point by meshopt
const MESHOPT_SHARE = 1 / 3; // of the time that Draco takes to decode a point
// The first probe fits what TCP sends at once. If it takes so long, the line is slow, and larger ones would keep it busy.
const SMALL_PROBE = 8 << 10;
const LARGE_PROBE = 256 << 10;
const SLOW_MS = 10;
const PROBE_MS = 5000; // then the line counts as not measured

export interface EncodingChoice {
  readonly encoding: 'draco' | 'meshopt';
  /** For people. */
  readonly reason: string;
}

/**
 * @param lineRate Bytes a second.
 * @param dracoNs What a worker takes to decode a point of Draco.
 * @param workers How many decode at once.
 */
export function chooseEncoding(lineRate: number, dracoNs: number, workers: number): EncodingChoice {
  const extra = (1e9 * MORE_BYTES) / lineRate;
  const saved = (dracoNs * (1 - MESHOPT_SHARE)) / workers;
  return {
    encoding: extra < saved ? 'meshopt' : 'draco',
    reason: `meshopt's ${MORE_BYTES} bytes more a point take ${extra.toFixed(1)} ns at ${(lineRate / 1e6).toPrecision(3)} MB/s, decoding saves ${saved.toFixed(1)} ns`,
  };
}

/** Chooses by the rates of this page, once points of Draco have been decoded. Undefined before that. */
export async function measuredChoice(server: LatticedServer, info: ServerInfo, pool: DecodePool): Promise<EncodingChoice | undefined> {
  if (!info.encodings.includes(Encoding.MESHOPT)) return { encoding: 'draco', reason: 'the server has no meshopt' };
  if (!pool.hasOwnDecoder) return { encoding: 'draco', reason: 'this browser has no WebAssembly SIMD' };
  if (pool.dracoNs === undefined) return undefined;
  const lineRate = await measureLine(server).catch(() => undefined);
  if (lineRate === undefined) return { encoding: 'draco', reason: 'the line could not be measured' };
  return chooseEncoding(lineRate, pool.dracoNs, pool.size);
}

/** Bytes a second. The last of two large probes counts: TCP's windows have grown by then. */
async function measureLine({ server }: LatticedServer): Promise<number> {
  const timed = async (probeBytes: number): Promise<number> => {
    const begin = performance.now();
    await server.getServerInfo({ probeBytes }, { timeoutMs: PROBE_MS });
    return performance.now() - begin;
  };
  const roundTrip = await timed(0);
  const rate = (bytes: number, ms: number): number => (1000 * bytes) / Math.max(ms - roundTrip, ms / 10);
  const small = await timed(SMALL_PROBE);
  if (small - roundTrip > SLOW_MS) return rate(SMALL_PROBE, small);
  await timed(LARGE_PROBE);
  return rate(LARGE_PROBE, await timed(LARGE_PROBE));
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ChunkForm, PointNumbers } from './chunk_form';

/** What a worker is told first. */
export interface DecodeStart {
  readonly kind: 'start';
  readonly wasm: ArrayBuffer;
}

/** One chunk to decode; `data` is the worker's from then on, as `reuse`, an earlier result that nobody needs. */
export interface DecodeJob {
  readonly kind: 'job';
  readonly id: number;
  readonly data: Uint8Array<ArrayBuffer>;
  readonly form: ChunkForm;
  readonly reuse?: ArrayBuffer;
}

export type DecodeRequest = DecodeStart | DecodeJob;

/** The answer to a job: points and extent, or why there are none. */
export interface DecodeAnswer {
  readonly id: number;
  readonly points?: PointNumbers;
  readonly extent?: Float32Array;
  /** Time in the worker. */
  readonly ms: number;
  readonly error?: string;
}

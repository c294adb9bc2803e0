// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { fetchAsset } from '../wire/asset';
import type { ChunkForm, DecodedChunk } from './chunk_form';

/** The names of the built files beside the page's script. build.mjs defines it. */
declare const DECODER_FILES: { readonly worker: string; readonly wasm: string | undefined; readonly draco3d: Draco3dFiles };

/** The module of draco_chunk.ts, and draco3d's draco_decoder.wasm. */
interface Draco3dFiles {
  readonly script: string;
  readonly wasm: string;
}

/** The first message to a worker. */
export interface DecodeStart {
  readonly kind: 'start';
  /** decoder.wasm; without it draco3d decodes. */
  readonly wasm: ArrayBuffer | undefined;
  /** Addresses. */
  readonly draco3d: Draco3dFiles;
}

/** Chunks to decode together. `data` and `reuse`, of an earlier batch that nobody needs, are transferred to the worker. */
export interface DecodeBatch {
  readonly kind: 'batch';
  readonly id: number;
  /** The streams of all chunks, one after the other. */
  readonly data: Uint8Array<ArrayBuffer>;
  readonly chunks: readonly { readonly bytes: number; readonly form: ChunkForm }[];
  readonly reuse?: ArrayBuffer | undefined;
}

export type DecodeRequest = DecodeStart | DecodeBatch;

/** The answer to a batch: the points of each chunk in `memory`, or why there are none. */
export interface DecodeAnswer {
  readonly id: number;
  readonly memory: ArrayBuffer;
  /** The time that the worker took. */
  readonly ms: number;
  readonly chunks: readonly (DecodedChunk | string)[];
}

/** The part of a Worker that the pool uses. */
export interface DecodeWorker {
  onmessage: ((event: { data: DecodeAnswer }) => void) | null;
  onerror: ((event: { message?: string }) => void) | null;
  postMessage(message: DecodeRequest, transfer: ArrayBuffer[]): void;
}

/** A chunk that is being decoded or waits for it. */
export interface PendingChunk {
  readonly result: Promise<DecodedChunk>;
  /** Removes the chunk from the queue; `result` then never settles. Returns false if a worker already took it. */
  cancel(): boolean;
}

interface Job {
  readonly id: number;
  readonly data: Uint8Array<ArrayBuffer>;
  readonly form: ChunkForm;
  readonly resolve: (chunk: DecodedChunk) => void;
  readonly reject: (error: Error) => void;
}

/**
 * Decodes chunks in workers, in the order of the calls. A worker has at most eight batches, so that all other chunks can be
 * cancelled, and it does not wait for the page. The caller bounds the queue: a stream has at most two unacknowledged updates.
 */
export class DecodePool {
  private static readonly BATCHES_PER_WORKER = 8;
  private static readonly POINTS_PER_BATCH = 34_000; // 16 chunks of 32 patches of 10 segments, about 0.6 ms
  private static readonly SPARE_BUFFERS = 64;
  private static readonly MEASURED_MS = 5; // clocks of browsers are coarse

  private readonly queue: Job[] = [];
  private readonly running = new Map<number, readonly Job[]>(); // by batch
  private readonly load: number[];
  private readonly spare: ArrayBuffer[] = [];
  private readonly users = new WeakMap<ArrayBuffer, number>(); // how many of its chunks were not given back
  private nextId = 1;
  private isPumping = false;
  private failure: Error | undefined;
  private readonly draco = { ms: 0, points: 0 }; // of all batches without another encoding

  /** Whether this browser can run decoder.wasm. draco3d decodes otherwise. */
  readonly hasOwnDecoder: boolean;

  /**
   * @param wasm decoder.wasm, if there is one.
   * @param draco3d The addresses of draco3d's files.
   */
  constructor(private readonly workers: readonly DecodeWorker[], wasm: ArrayBuffer | undefined, draco3d: Draco3dFiles) {
    this.load = workers.map(() => 0);
    this.hasOwnDecoder = wasm !== undefined && WebAssembly.validate(wasm);
    workers.forEach((worker, number) => {
      worker.onmessage = ({ data }) => this.answered(number, data);
      worker.onerror = ({ message }) => this.fail(new Error(`a decoding worker failed: ${message ?? 'not loaded'}`));
      worker.postMessage({ kind: 'start', wasm, draco3d }, []);
    });
  }

  /** Starts a worker for each hardware thread but one: at least 1, at most 6. */
  static async inBrowser(): Promise<DecodePool> {
    const { worker, wasm, draco3d } = DECODER_FILES;
    const own = wasm === undefined ? undefined : await (await fetchAsset(wasm)).arrayBuffer();
    const count = Math.min(Math.max((navigator.hardwareConcurrency || 2) - 1, 1), 6);
    const workers = Array.from({ length: count }, () => new Worker(new URL(worker, import.meta.url), { type: 'module' }));
    const address = (name: string): string => new URL(name, import.meta.url).href;
    return new DecodePool(workers as DecodeWorker[], own, { script: address(draco3d.script), wasm: address(draco3d.wasm) });
  }

  /** Decodes one chunk. The pool owns `data` from then on. */
  decode(data: Uint8Array<ArrayBuffer>, form: ChunkForm): PendingChunk {
    const id = this.nextId++;
    const result = new Promise<DecodedChunk>((resolve, reject) => {
      if (this.failure) reject(this.failure);
      else this.queue.push({ id, data, form, resolve, reject });
    });
    this.pumpSoon();
    return { result, cancel: () => this.cancel(id) };
  }

  /** Takes back the memory of a decoded chunk that nobody reads any more. */
  giveBack(chunk: DecodedChunk): void {
    const memory = chunk.points.buffer as ArrayBuffer;
    const users = this.users.get(memory);
    if (users === undefined) return;
    if (users > 1) return void this.users.set(memory, users - 1);
    this.users.delete(memory);
    if (this.spare.length < DecodePool.SPARE_BUFFERS) this.spare.push(memory);
  }

  /** How many chunks are decoded at once. */
  get size(): number {
    return this.workers.length;
  }

  /** What a worker takes for a point of Draco; undefined until enough were decoded. */
  get dracoNs(): number | undefined {
    const { ms, points } = this.draco;
    return ms < DecodePool.MEASURED_MS ? undefined : (1e6 * ms) / points;
  }

  /** Chunks that wait or are being decoded. */
  get pending(): number {
    return [...this.running.values()].reduce((sum, { length }) => sum + length, this.queue.length);
  }

  private cancel(id: number): boolean {
    const at = this.queue.findIndex((job) => job.id === id);
    if (at >= 0) this.queue.splice(at, 1);
    return at >= 0;
  }

  /** The chunks of one message come together: they are sent once all are there. */
  private pumpSoon(): void {
    if (this.isPumping) return;
    this.isPumping = true;
    queueMicrotask(() => {
      this.isPumping = false;
      this.pump();
    });
  }

  private pump(): void {
    while (this.queue.length) {
      const number = this.load.indexOf(Math.min(...this.load));
      if (this.load[number]! >= DecodePool.BATCHES_PER_WORKER) return;
      ++this.load[number]!;
      this.send(this.workers[number]!, this.nextBatch());
    }
  }

  private nextBatch(): Job[] {
    let points = 0;
    const past = this.queue.findIndex(({ form }) => (points += form.points) > DecodePool.POINTS_PER_BATCH);
    return this.queue.splice(0, past < 0 ? this.queue.length : Math.max(past, 1));
  }

  private send(worker: DecodeWorker, jobs: readonly Job[]): void {
    const id = this.nextId++;
    this.running.set(id, jobs);
    const data = new Uint8Array(jobs.reduce((sum, job) => sum + job.data.length, 0));
    let end = 0;
    for (const job of jobs) {
      data.set(job.data, end);
      end += job.data.length;
    }
    const reuse = this.spare.pop();
    const chunks = jobs.map((job) => ({ bytes: job.data.length, form: job.form }));
    worker.postMessage({ kind: 'batch', id, data, chunks, reuse }, reuse ? [data.buffer, reuse] : [data.buffer]);
  }

  private answered(number: number, { id, memory, ms, chunks }: DecodeAnswer): void {
    --this.load[number]!;
    const jobs = this.running.get(id) ?? [];
    this.running.delete(id);
    const decoded = chunks.filter((chunk) => typeof chunk !== 'string');
    if (decoded.length === jobs.length && jobs.every(({ form }) => form.encoding === 'draco')) {
      this.draco.ms += ms;
      this.draco.points += jobs.reduce((sum, { form }) => sum + form.points, 0);
    }
    if (decoded.length) this.users.set(memory, decoded.length);
    jobs.forEach((job, i) => {
      const chunk = chunks[i] ?? 'a worker answered nothing';
      if (typeof chunk === 'string') job.reject(new Error(chunk));
      else job.resolve(chunk);
    });
    this.pump();
  }

  private fail(error: Error): void {
    this.failure = error;
    for (const job of [...[...this.running.values()].flat(), ...this.queue]) job.reject(error);
    this.running.clear();
    this.queue.length = 0;
  }
}

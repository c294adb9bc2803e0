// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Chunks, PatchLattice, Quantisation, Topology, UpdateBegin, UpdateEnd } from 'latticed/v1/event_pb';
import { NormalMode, type ViewOptions } from 'latticed/v1/view_pb';
import type { ChunkForm } from '../decode/chunk_form';
import type { DecodePool, PendingChunk } from '../decode/decode_pool';
import type { Lattice } from '../lattice/lattice';
import type { EdgeRun, EdgeUpdate } from '../patches/levels/edge_bounds';
import type { Grid, SurfaceUpdate } from '../surface/surface_update';
import { TopologyLayout, type PatternCodes } from '../surface/topology_layout';
import { vector } from '../wire/lattice_message';
import { encodingOf } from '../wire/view_message';
import { SummedLattice } from './summed_lattice';

/** One update on its way from the wire to the surface. */
interface Incoming {
  readonly view: ViewOptions | undefined;
  readonly begun: number;  // performance.now()
  readonly chunks: Map<number, { readonly codes: PatternCodes; readonly decoding: PendingChunk }>;
  /** Bounds of edges, in a view without points. */
  bounds: EdgeRun[];
  /** The lattice of its patches, if the scene has several. */
  sum?: Lattice;
  layout?: TopologyLayout;
  grid?: Grid;
  unseen?: bigint;
  bytes: number;
  /** Absent before update_end has come. */
  end?: UpdateEnd;
  isCancelled: boolean;
  ofLostStream: boolean;
}

/** An update that is whole and decoded. */
export interface ReceivedUpdate extends Pick<Incoming, 'ofLostStream' | 'unseen' | 'view' | 'bytes' | 'sum'> {
  readonly end: UpdateEnd;
  /** Absent if no chunk changed. */
  readonly surface: SurfaceUpdate | undefined;
  /** The same for a view without points. */
  readonly edges: EdgeUpdate | undefined;
  /** Patches in its chunks, each counted once. */
  readonly patches: number;
  /** From update_begin to update_end, in ms. */
  readonly transferMs: number;
  /** From update_end until all was decoded, in ms. */
  readonly decodeMs: number;
}

/**
 * Gathers updates. Chunks are decoded as they come. An update is handed on, in order, when it has ended and is decoded.
 * If the next one has ended by then, both become one, without the older chunks that the next one replaces.
 */
export class UpdateReceiver {
  private static readonly LAYOUTS_KEPT = 4;

  private readonly layouts = new Map<string, TopologyLayout>();
  private readonly grids = new Map<bigint, Grid>();
  private readonly summed = new SummedLattice();
  private incoming: Incoming | undefined;
  private ended: Incoming | undefined;

  /**
   * @param received Gets whole updates in order; what it throws goes to `failed`. `ofLostStream`: the update's number
   *   means nothing to the stream that is open now. `unseen`: the newest update of the same stream that was merged into
   *   this one.
   * @param failed Called if an update cannot be decoded; the stream is of no use then.
   */
  constructor(
    private readonly pool: DecodePool,
    private readonly received: (update: ReceivedUpdate) => void,
    private readonly failed: (error: Error) => void,
  ) {}

  topology(message: Topology): void {
    this.layouts.delete(message.topologyId);
    this.layouts.set(message.topologyId, new TopologyLayout(message));
    while (this.layouts.size > UpdateReceiver.LAYOUTS_KEPT) this.layouts.delete(this.layouts.keys().next().value!);
  }

  quantisation(message: Quantisation): void {
    this.grids.clear();
    this.grids.set(message.quantisationId, {
      origin: vector(message.origin), step: message.bits ? message.step : 1, range: message.step * (2 ** message.bits - 1),
      positionBits: message.bits, normalBits: message.normalBits });
  }

  begin({ view }: UpdateBegin): void {
    this.drop(this.incoming);
    this.incoming = { view, begun: performance.now(), chunks: new Map(), bounds: [], bytes: 0, isCancelled: false, ofLostStream: false };
  }

  patchLattice(message: PatchLattice): void {
    const sum = this.summed.take(message);
    if (this.incoming) this.incoming.sum = sum;
  }

  chunks(message: Chunks): void {
    const update = this.incoming;
    if (!update) return;
    const layout = this.layouts.get(message.topologyId);
    if (layout && update.view && encodingOf(update.view) === 'patches') return this.takeBounds(update, layout, message);
    const grid = this.grids.get(message.quantisationId);
    if (!layout || !grid || !update.view) throw new Error('chunks of a layout or grid that was not sent');
    Object.assign(update, { layout, grid });
    for (const { index, data, levels } of message.chunks) {
      update.bytes += data.length + levels.length;
      const codes = codesOf(levels);
      const encoding = encodingOf(update.view) as ChunkForm['encoding'];
      const decoding = this.pool.decode(data as Uint8Array<ArrayBuffer>, {
        encoding, points: layout.pointsOf(index, codes),
        normals: hasNormals(update.view), positionBits: grid.positionBits, normalBits: grid.normalBits });
      update.chunks.set(index, { codes, decoding });
    }
  }

  private takeBounds(update: Incoming, layout: TopologyLayout, { chunks }: Chunks): void {
    update.layout = layout;
    for (const { index, chunkCount, firstEdge, data } of chunks) {
      update.bytes += data.length;
      update.bounds.push({ firstChunk: index, chunkCount: chunkCount || 1, firstEdge, bytes: data });
    }
  }

  end(end: UpdateEnd): void {
    const { incoming: update, ended: older } = this;
    if (!update) return;
    if (older) {
      this.merge(older, update);
      if (!older.ofLostStream) update.unseen = older.end!.updateId;
      older.isCancelled = true;
    }
    this.incoming = undefined;
    this.ended = update;
    update.end = end;
    void this.finish(update, end);
  }

  /** The stream is lost: an update that has not ended is dropped. */
  reset(): void {
    this.drop(this.incoming);
    this.incoming = undefined;
    if (this.ended) this.ended.ofLostStream = true;
  }

  /** Nothing more is handed on. */
  close(): void {
    this.reset();
    if (this.ended) this.ended.isCancelled = true;
    this.ended = undefined;
  }

  private async finish(update: Incoming, end: UpdateEnd): Promise<void> {
    const at = performance.now();
    try {
      const chunks = await Promise.all(
        Array.from(update.chunks, async ([index, { codes, decoding }]) => ({ index, codes, decoded: await decoding.result })));
      if (update.isCancelled) return;
      this.ended = undefined;
      const { layout, grid, view, bounds } = update;
      this.received({
        ...update, end,
        surface: layout && grid && chunks.length ? { layout, grid, normals: hasNormals(view), chunks } : undefined,
        edges: layout && bounds.length ? { layout, normals: view!.normals, runs: bounds } : undefined,
        patches: Array.from(new Set([...update.chunks.keys(), ...chunksOf(bounds)])).reduce((sum, index) => sum + layout!.patchesOf(index), 0),
        transferMs: at - update.begun,
        decodeMs: performance.now() - at,
      });
      for (const { decoded } of chunks) this.pool.giveBack(decoded);
    } catch (error) {
      if (!update.isCancelled) this.failed(error as Error);
    }
  }

  /** Moves to `newer` the chunks that only `older` has, unless layout or grid differ. `older` is not handed on. */
  private merge(older: Incoming, newer: Incoming): void {
    const sameForm = !newer.layout || (newer.layout.id === older.layout?.id && newer.grid === older.grid);
    for (const [index, chunk] of older.chunks) {
      if (!sameForm || newer.chunks.has(index)) chunk.decoding.cancel();
      else newer.chunks.set(index, chunk);
    }
    if (sameForm) newer.bounds = [...older.bounds, ...newer.bounds];
    if (!newer.layout) Object.assign(newer, { layout: older.layout, grid: older.grid });
    newer.bytes += older.bytes;
  }

  private drop(update: Incoming | undefined): void {
    for (const { decoding } of update?.chunks.values() ?? []) {
      decoding.cancel();
      decoding.result.catch(() => undefined);
    }
  }
}

function hasNormals(view: ViewOptions | undefined): boolean {
  return view !== undefined && view.normals !== NormalMode.NONE;
}

function chunksOf(runs: readonly EdgeRun[]): number[] {
  return runs.flatMap(({ firstChunk, chunkCount }) => Array.from({ length: chunkCount }, (_, at) => firstChunk + at));
}

/** Chunk.levels: little-endian uint16, like numbers in memory on every machine that runs browsers. */
function codesOf(levels: Uint8Array): PatternCodes {
  return new Uint16Array(levels.slice().buffer, 0, levels.length >> 1);
}

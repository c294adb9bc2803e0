// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Chunks, Quantisation, Topology, UpdateBegin, UpdateEnd } from 'latticed/v1/event_pb';
import { NormalMode, type ViewOptions } from 'latticed/v1/view_pb';
import type { DecodedChunk } from '../decode/chunk_form';
import type { DecodePool, PendingChunk } from '../decode/decode_pool';
import type { Grid, SurfaceUpdate } from '../surface/surface_mesh';
import { TopologyLayout } from '../surface/topology_layout';
import { vector } from '../wire/lattice_message';
import { encodingOf } from '../wire/view_message';

/** One update on its way from the wire to the surface. */
interface Incoming {
  readonly view: ViewOptions | undefined;
  readonly begun: number;  // performance.now()
  readonly chunks: Map<number, PendingChunk>;
  layout?: TopologyLayout;
  grid?: Grid;
  unseen?: bigint;
  bytes: number;
}

/** One that has ended, while it is decoded. */
interface Ended {
  readonly update: Incoming;
  readonly end: UpdateEnd;
  readonly at: number;  // performance.now()
  cancelled: boolean;
  ofLostStream: boolean;
}

/** An update that is whole and decoded. */
export interface ReceivedUpdate {
  readonly end: UpdateEnd;
  /** Its number means nothing to the stream that is open now. */
  readonly ofLostStream: boolean;
  /** The newest update of the same stream that ended before and was not handed on by itself. */
  readonly unseen: bigint | undefined;
  /** In force; absent where the update began without. */
  readonly view: ViewOptions | undefined;
  /** Absent where no chunk changed. */
  readonly surface: SurfaceUpdate | undefined;
  readonly bytes: number;
  /** In its chunks, each counted once. */
  readonly patches: number;
  /** From update_begin to update_end, in ms. */
  readonly transferMs: number;
  /** From update_end until all was decoded, in ms. */
  readonly decodeMs: number;
}

/**
 * Gathers updates: chunks are decoded as they come, and an update is handed on when it has ended and all of it is
 * decoded, in order. Where the next one has ended by then, both become one, less what the older one need not decode.
 */
export class UpdateReceiver {
  private static readonly LAYOUTS_KEPT = 4;

  private readonly layouts = new Map<string, TopologyLayout>();
  private readonly grids = new Map<bigint, Grid>();
  private incoming: Incoming | undefined;
  private ended: Ended | undefined;

  /**
   * @param received Gets whole updates in order; what it throws goes to failed.
   * @param failed Gets what could not be decoded; the stream is of no use then.
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
      origin: vector(message.origin), step: message.bits ? message.step : 1, normalBits: message.normalBits });
  }

  begin(message: UpdateBegin): void {
    this.drop(this.incoming);
    this.incoming = { view: message.view, begun: performance.now(), chunks: new Map(), bytes: 0 };
  }

  chunks(message: Chunks): void {
    const update = this.incoming;
    if (!update) return;
    const layout = this.layouts.get(message.topologyId);
    const grid = this.grids.get(message.quantisationId);
    if (!layout || !grid || !update.view) throw new Error('chunks of a layout or grid that was not sent');
    update.layout = layout;
    update.grid = grid;
    for (const { index, data } of message.chunks) {
      update.bytes += data.length;
      update.chunks.set(index, this.pool.decode(data as Uint8Array<ArrayBuffer>, {
        encoding: encodingOf(update.view), points: layout.pointsOf(index),
        normals: hasNormals(update.view), normalBits: grid.normalBits }));
    }
  }

  end(message: UpdateEnd): void {
    const update = this.incoming;
    if (!update) return;
    this.incoming = undefined;
    if (this.ended) {
      this.merge(this.ended.update, update);
      if (!this.ended.ofLostStream) update.unseen = this.ended.end.updateId;
    }
    const ended = { update, end: message, at: performance.now(), cancelled: false, ofLostStream: false };
    if (this.ended) this.ended.cancelled = true;
    this.ended = ended;
    void this.finish(ended);
  }

  /** The stream is lost: what has not ended does not count. */
  reset(): void {
    this.drop(this.incoming);
    this.incoming = undefined;
    if (this.ended) this.ended.ofLostStream = true;
  }

  /** Nothing more is handed on. */
  close(): void {
    this.reset();
    if (this.ended) this.ended.cancelled = true;
    this.ended = undefined;
  }

  private async finish(ended: Ended): Promise<void> {
    const { update, end, at } = ended;
    try {
      const chunks = await decodedOf(update);
      if (ended.cancelled) return;
      this.ended = undefined;
      const decodeMs = performance.now() - at;
      const { layout, grid, view } = update;
      const surface = layout && grid && chunks.length ? { layout, grid, normals: hasNormals(view), chunks } : undefined;
      const patches = chunks.reduce((sum, { index }) => sum + layout!.patchesOf(index), 0);
      this.received({
        end, ofLostStream: ended.ofLostStream, unseen: update.unseen, view, surface, bytes: update.bytes, patches, transferMs: at - update.begun, decodeMs });
      for (const { decoded } of chunks) this.pool.giveBack(decoded);
    } catch (error) {
      if (!ended.cancelled) this.failed(error as Error);
    }
  }

  /** Takes what `newer` lacks of `older`, which is not shown by itself, if both are of one layout and grid. */
  private merge(older: Incoming, newer: Incoming): void {
    const sameForm = !newer.layout || (newer.layout.id === older.layout?.id && newer.grid === older.grid);
    for (const [index, chunk] of older.chunks) {
      if (!sameForm || newer.chunks.has(index)) chunk.cancel();
      else newer.chunks.set(index, chunk);
    }
    if (!newer.layout && older.layout && older.grid) {
      newer.layout = older.layout;
      newer.grid = older.grid;
    }
    newer.bytes += older.bytes;
  }

  private drop(update: Incoming | undefined): void {
    for (const chunk of update?.chunks.values() ?? []) {
      chunk.cancel();
      chunk.result.catch(() => undefined);
    }
  }
}

function hasNormals(view: ViewOptions | undefined): boolean {
  return view !== undefined && view.normals !== NormalMode.NONE;
}

async function decodedOf(update: Incoming): Promise<{ index: number; decoded: DecodedChunk }[]> {
  return Promise.all(Array.from(update.chunks, async ([index, chunk]) => ({ index, decoded: await chunk.result })));
}

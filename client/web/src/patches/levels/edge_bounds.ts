// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { NormalMode } from 'latticed/v1/view_pb';
import type { TopologyLayout } from '../../surface/topology_layout';

/** The bounds of edges that an update of a view with ENCODING_PATCHES brings. */
export interface EdgeUpdate {
  readonly layout: TopologyLayout;
  readonly normals: NormalMode;
  /** By chunk: a byte for each edge that a patch of the chunk uses first (patches.proto, Levels). */
  readonly chunks: ReadonlyMap<number, Uint8Array>;
}

/** The newest bounds of all edges of a view. */
export class EdgeBounds {
  private newest: EdgeUpdate | undefined;
  private chunks = new Map<number, Uint8Array>();
  private changed = new Set<number>();

  get layout(): TopologyLayout | undefined {
    return this.newest?.layout;
  }

  get normals(): NormalMode | undefined {
    return this.newest?.normals;
  }

  take(update: EdgeUpdate): void {
    if (update.layout.id !== this.layout?.id) this.clear();
    this.newest = update;
    for (const [chunk, bytes] of update.chunks) {
      this.chunks.set(chunk, bytes);
      this.changed.add(chunk);
    }
  }

  /** The view has points again. */
  clear(): void {
    this.newest = undefined;
    this.chunks = new Map();
    this.changed = new Set();
  }

  /** Whether all chunks have come. */
  get isComplete(): boolean {
    return this.newest !== undefined && this.chunks.size === this.newest.layout.chunkCount;
  }

  /**
   * Writes the chunks that have come since the call before into `bytes`, of all edges, and returns their numbers.
   *
   * @param edgesBefore PatchPlan.edgesBefore. Throws if a chunk has another number of edges than the plan.
   */
  writeNew(bytes: Uint8Array, edgesBefore: Uint32Array): number[] {
    const written = [...this.changed];
    this.changed = new Set();
    for (const chunk of written) {
      const { firstPatch } = this.newest!.layout;
      const [first, end] = [edgesBefore[firstPatch[chunk]!]!, edgesBefore[firstPatch[chunk + 1]!]!];
      const own = this.chunks.get(chunk)!;
      if (own.length !== end - first) throw new Error(`chunk ${chunk} has ${own.length} edges in place of ${end - first}`);
      bytes.set(own, first);
    }
    return written;
  }

  /** All chunks are to be written again, for a plan that has come later. */
  writeAllAgain(): void {
    this.changed = new Set(this.chunks.keys());
  }
}

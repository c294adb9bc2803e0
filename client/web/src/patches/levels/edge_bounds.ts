// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { NormalMode } from 'latticed/v1/view_pb';
import type { LatticeStructure } from '../../lattice/grid';
import type { Lattice } from '../../lattice/lattice';
import type { TopologyLayout } from '../../surface/topology_layout';

/** Consecutive chunks of a view with ENCODING_PATCHES. */
export interface EdgeRun {
  readonly firstChunk: number;
  readonly chunkCount: number;
  readonly firstEdge: number;
  /** A byte for each edge that a patch of the chunks uses first (patches.proto, Levels). */
  readonly bytes: Uint8Array;
}

/** The bounds of edges that an update brings. */
export interface EdgeUpdate {
  readonly layout: TopologyLayout;
  readonly normals: NormalMode;
  /** A later one replaces bounds of an earlier one. */
  readonly runs: readonly EdgeRun[];
}

/** The newest bounds of all edges of a view. */
export class EdgeBounds {
  private newest: EdgeUpdate | undefined;
  private ofStructure: LatticeStructure | undefined;
  private ofSum: Lattice | undefined;
  /** Of all edges; longer than they are many. */
  private bytes = new Uint8Array(0);
  private edgeCount = 0;
  private chunks = new Set<number>();
  private changed = new Set<number>();

  get layout(): TopologyLayout | undefined {
    return this.newest?.layout;
  }

  get normals(): NormalMode | undefined {
    return this.newest?.normals;
  }

  /** The structure of the lattice that the bounds are of; undefined: not known yet. */
  get structure(): LatticeStructure | undefined {
    return this.ofStructure;
  }

  /** The lattice that the bounds are of, if the scene has several: their sum, as of the newest update. */
  get sum(): Lattice | undefined {
    return this.ofSum;
  }

  take(update: EdgeUpdate): void {
    if (update.layout.id !== this.layout?.id) {
      this.clear();
      this.bytes = new Uint8Array(3 * update.layout.patchCount);
    }
    this.newest = update;
    for (const { firstChunk, chunkCount, firstEdge, bytes } of update.runs) {
      const end = firstEdge + bytes.length;
      if (end > this.bytes.length) throw new Error(`bounds of ${end} edges, but ${this.bytes.length / 3} patches`);
      this.bytes.set(bytes, firstEdge);
      this.edgeCount = Math.max(this.edgeCount, end);
      for (let chunk = firstChunk; chunk < firstChunk + chunkCount; ++chunk) this.changed.add(chunk);
    }
    for (const chunk of this.changed) this.chunks.add(chunk);
  }

  /**
   * An update has come, with bounds or without, at whose revision the lattice has this structure, if that is known. Of several
   * lattices, `sum` is what counts.
   */
  updated(structure: LatticeStructure | undefined, sum?: Lattice): void {
    if (!this.newest) return;
    if ((sum === undefined) !== (this.ofSum === undefined)) this.ofStructure = undefined;
    this.ofSum = sum;
    this.ofStructure ??= sum ?? structure; // a layout gets another structure only where several lattices become one, or one several
  }

  /** The view has points again. */
  clear(): void {
    this.newest = this.ofStructure = this.ofSum = undefined;
    this.bytes = new Uint8Array(0);
    this.edgeCount = 0;
    this.chunks = new Set();
    this.changed = new Set();
  }

  /** Whether all chunks have come. */
  get isComplete(): boolean {
    return this.newest !== undefined && this.chunks.size === this.newest.layout.chunkCount;
  }

  /**
   * Writes the chunks that have come since the call before into `bytes`, of all edges, and returns their numbers.
   *
   * @param edgesBefore PatchPlan.edgesBefore. Throws if the plan has another number of edges.
   */
  writeNew(bytes: Uint8Array, edgesBefore: Uint32Array): number[] {
    if (this.edgeCount !== bytes.length) throw new Error(`bounds of ${this.edgeCount} edges in place of ${bytes.length}`);
    const written = [...this.changed];
    this.changed = new Set();
    for (const chunk of written) {
      const { firstPatch } = this.newest!.layout;
      const [first, end] = [edgesBefore[firstPatch[chunk]!]!, edgesBefore[firstPatch[chunk + 1]!]!];
      bytes.set(this.bytes.subarray(first, end), first);
    }
    return written;
  }

  /** All chunks are to be written again, for a plan that has come later. */
  writeAllAgain(): void {
    this.changed = new Set(this.chunks);
  }
}

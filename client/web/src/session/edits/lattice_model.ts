// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { indicesTo } from '../../lattice/index_sets';
import type { Lattice } from '../../lattice/lattice';
import { sameStructure } from '../../lattice/grid';
import type { EditQueue } from './edit_queue';
import type { Targets } from './edit_targets';

/**
 * The lattice that is shown: the server's newest one with this window's edits on top, in their order.
 *
 * The server's states and deltas may come before or after the answers to these edits. The queue drops an edit only when
 * both have arrived, so the cage never jumps back.
 */
export class LatticeModel {
  private shownLattice: Lattice;

  constructor(
    private server: Lattice, public structureId: bigint, public revision: bigint, private readonly queue: EditQueue,
  ) {
    this.shownLattice = server.clone();
  }

  get shown(): Lattice {
    return this.shownLattice;
  }

  /** Takes a whole lattice. Returns whether its structure is another one, so that `shown` is a new object. */
  takeState(lattice: Lattice, structureId: bigint, revision: bigint): boolean {
    const changed = structureId !== this.structureId || !sameStructure(lattice, this.server);
    this.server = lattice;
    this.structureId = structureId;
    this.revision = revision;
    if (changed) this.shownLattice = lattice.clone();
    return changed;
  }

  takeDelta(targets: Targets, revision: bigint): void {
    write(this.server, targets);
    this.revision = revision;
  }

  /** Shows an edit of this window on top of the others. */
  show(targets: Targets): void {
    write(this.shownLattice, targets);
  }

  /**
   * Puts points where the server and the overlays have them; returns those that moved, all if the strength is another one.
   * Absent: all points.
   */
  refresh(indices: Uint32Array = Uint32Array.from(indicesTo(this.server.count))): Uint32Array {
    const { points, strength } = this.shownLattice;
    this.shownLattice.strength = this.server.strength;
    const before = new Float64Array(3 * indices.length);
    indices.forEach((index, i) => {
      for (let axis = 0; axis < 3; ++axis) {
        before[3 * i + axis] = points[3 * index + axis]!;
        points[3 * index + axis] = this.server.points[3 * index + axis]!;
      }
    });
    for (const targets of this.queue.overlays(this.structureId)) write(this.shownLattice, targets);
    if (this.shownLattice.strength !== strength) return Uint32Array.from(indicesTo(this.server.count));
    return indices.filter((index, i) =>
      [0, 1, 2].some((axis) => before[3 * i + axis] !== points[3 * index + axis]));
  }
}

function write(lattice: Lattice, { indices, positions, strength }: Targets): void {
  const { points } = lattice;
  lattice.strength = strength ?? lattice.strength;
  indices.forEach((index, i) => {
    for (let axis = 0; axis < 3; ++axis) points[3 * index + axis] = positions[3 * i + axis]!;
  });
}

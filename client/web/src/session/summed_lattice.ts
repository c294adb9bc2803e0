// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { PatchLattice } from 'latticed/v1/event_pb';
import type { Lattice } from '../lattice/lattice';
import { toLattice } from '../wire/lattice_message';

/** The sum of several lattices, which patches are of: followed from update to update, also through those that do not end. */
export class SummedLattice {
  private newest: Lattice | undefined;

  /** The lattice after this message: another object each time, and older ones stay as they are. */
  take({ news }: PatchLattice): Lattice {
    if (news.case === 'state') return (this.newest = toLattice(news.value.lattice!));
    const moved = this.newest?.clone();
    if (!moved || news.case !== 'delta') throw new Error('a patch_lattice without the one before');
    const { indices, positions } = news.value;
    if (positions.length !== 3 * indices.length) throw new Error('a patch_lattice whose positions do not fit its control points');
    indices.forEach((index, i) => {
      if (index >= moved.count) throw new Error('a patch_lattice names a control point that does not exist');
      for (let axis = 0; axis < 3; ++axis) moved.points[3 * index + axis] = positions[3 * i + axis]!;
    });
    return (this.newest = moved);
  }
}

/** The control points in which two lattices of the same size differ. */
export function movedPoints(before: Lattice, after: Lattice): number[] {
  const moved: number[] = [];
  for (let index = 0; index < after.count; ++index) {
    if ([0, 1, 2].some((axis) => before.points[3 * index + axis] !== after.points[3 * index + axis])) moved.push(index);
  }
  return moved;
}

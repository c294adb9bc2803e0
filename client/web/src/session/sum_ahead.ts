// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { sameStructure } from '../lattice/grid';
import { Lattice } from '../lattice/lattice';
import { Summand } from '../lattice/lattice_sum';

/** The lattices of a scene by their numbers. */
export type NumberedLattices = ReadonlyMap<number, Lattice>;

interface Base {
  readonly sum: Lattice;
  readonly lattices: NumberedLattices;
  readonly summands: ReadonlyMap<number, Summand>;
  /** What those lattices moved the sum then that have moved since. */
  readonly before: Map<number, Float64Array>;
}

/**
 * The sum of several lattices ahead of the server's updates: the sum of an update, and what the lattices have moved since. Where they
 * have not, it is that sum to the bit.
 */
export class SumAhead {
  private known: Pick<Base, 'sum' | 'lattices'> | undefined;
  private base: Base | undefined; // made once something has moved

  /** A sum that has come, and the lattices of its very revision: none if they are still to come, as after a restart of the server. */
  take(sum: Lattice, lattices: NumberedLattices): void {
    if (lattices.size === 0) return this.forget();
    this.known = { sum, lattices: new Map(Array.from(lattices, ([number, lattice]) => [number, lattice.clone()])) };
  }

  forget(): void {
    this.known = this.base = undefined;
  }

  /**
   * The sum of these lattices: the one that came if nothing has moved. Undefined if other lattices, or ones of other structures, were
   * there when it came.
   */
  of(lattices: NumberedLattices): Lattice | undefined {
    const { known } = this;
    if (!known || !sameStructures(known.lattices, lattices)) return undefined;
    const moved = Array.from(lattices).filter(([number, lattice]) => !sameMoves(lattice, known.lattices.get(number)!));
    if (moved.length === 0) return known.sum;
    if (this.base?.sum !== known.sum) this.base = based(known, this.base);
    const { sum, summands, before } = this.base;
    const points = sum.points.slice();
    for (const [number, lattice] of moved) {
      const summand = summands.get(number)!;
      if (!before.has(number)) before.set(number, summand.displacements(known.lattices.get(number)!));
      const then = before.get(number)!;
      summand.displacements(lattice).forEach((x, i) => (points[i]! += x - then[i]!));
    }
    return new Lattice(sum.frame, sum.degree, sum.size, sum.knots, points);
  }
}

function based({ sum, lattices }: Pick<Base, 'sum' | 'lattices'>, before: Base | undefined): Base {
  const isKnown = before && sameStructure(before.sum, sum) && sameStructures(before.lattices, lattices);
  const first = lattices.get(Math.min(...lattices.keys()))!;
  const summands = isKnown ? before.summands
    : new Map(Array.from(lattices, ([number, lattice]) => [number, new Summand(lattice, sum, first)]));
  return { sum, lattices, summands, before: new Map() };
}

function sameStructures(a: NumberedLattices, b: NumberedLattices): boolean {
  return a.size === b.size && Array.from(a).every(([number, lattice]) => b.has(number) && sameStructure(lattice, b.get(number)!));
}

function sameMoves(a: Lattice, b: Lattice): boolean {
  return a.strength === b.strength && a.points.every((x, i) => x === b.points[i]);
}

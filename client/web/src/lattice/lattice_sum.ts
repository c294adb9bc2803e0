// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What one of several lattices is in their sum (core/ffd/sum/README.md): E_w x E_v x E_u times its displacements.
import { AXES, domain, frameEdges, type Axis, type LatticeStructure } from './grid';
import { identityPoints } from './identity';
import { refine, type RefinedPoint } from './knot_refinement';
import type { Lattice } from './lattice';
import { OutsideMap } from './outside';
import { coordinates, sub } from './vec';

const ONE_KNOT = 2 ** -40; // of the range of an axis: nearer knots are one

export class Summand {
  private readonly outside: OutsideMap;
  private readonly rest: Float64Array;
  private readonly rows: readonly RefinedPoint[][];

  /**
   * @param sum The structure of a sum that this lattice is part of.
   * @param first The structure of the first of its lattices, of which the sum has the parameter.
   */
  constructor(readonly structure: LatticeStructure, sum: LatticeStructure, first: LatticeStructure) {
    this.outside = new OutsideMap(structure);
    const { continued } = this.outside;
    this.rest = identityPoints(continued);
    this.rows = AXES.map((axis) => {
      const target = { degree: sum.degree[axis], knots: Array.from(sum.knots[axis]) };
      const knots = structure === first ? continued.knots[axis] : placed(continued, first, axis);
      return refine({ degree: continued.degree[axis], knots: snapped(knots, sum, axis) }, target);
    });
  }

  /** What the lattice moves the control points of the sum, x y z each. It has this summand's structure. */
  displacements({ points, strength }: Lattice): Float64Array {
    const { size } = this.outside.continued;
    const moved = this.outside.points(points, strength).map((x, i) => x - this.rest[i]!);
    const [us, vs, ws] = this.rows as [RefinedPoint[], RefinedPoint[], RefinedPoint[]];
    const alongU = refined(us, moved, 3, size[0], size[1] * size[2]);
    const alongV = refined(vs, alongU, 3 * us.length, size[1], size[2]);
    return refined(ws, alongV, 3 * us.length * vs.length, size[2], 1);
  }
}

/**
 * The knots of a lattice in the parameter of the first one. Its given frame counts, as on the server: the origin of the sum is rounded,
 * which far from the origin of the world would part knots that are one.
 */
function placed(lattice: LatticeStructure, first: LatticeStructure, axis: Axis): Float64Array {
  const edges = frameEdges(first.frame);
  const [from, to] = domain(first, axis), [begin, end] = domain(lattice, axis);
  const at = from + (to - from) * coordinates(edges, sub(lattice.frame.origin, first.frame.origin))[axis];
  const scale = ((to - from) * coordinates(edges, frameEdges(lattice.frame)[axis])[axis]) / (end - begin);
  return lattice.knots[axis].map((knot) => at + scale * (knot - begin));
}

/** Knots that are the sum's to the bit where they are almost one of them: the nearest one. */
function snapped(knots: Float64Array, sum: LatticeStructure, axis: Axis): number[] {
  const [begin, end] = domain(sum, axis);
  const near = ONE_KNOT * (end - begin);
  return Array.from(knots, (knot) => {
    const nearest = sum.knots[axis].reduce((best, other) => (Math.abs(other - knot) < Math.abs(best - knot) ? other : best));
    return Math.abs(nearest - knot) <= near ? nearest : knot;
  });
}

/** `from` has `outer` blocks of `size` control points along an axis, each of `inner` numbers. */
function refined(rows: readonly RefinedPoint[], from: Float64Array, inner: number, size: number, outer: number): Float64Array {
  const to = new Float64Array(inner * rows.length * outer);
  for (let block = 0; block < outer; ++block) {
    rows.forEach(({ first, weights }, row) => weights.forEach((weight, k) => {
      const source = inner * (first + k + size * block), target = inner * (row + rows.length * block);
      for (let n = 0; n < inner; ++n) to[target + n]! += weight * from[source + n]!;
    }));
  }
  return to;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What one of several lattices is in their sum (core/ffd/sum/README.md): E_w x E_v x E_u times its displacements.
import { AXES, domain, frameEdges, type Axis, type LatticeStructure } from './grid';
import { identityPoints } from './identity';
import { refine, type AxisSpace, type RefinedPoint } from './knot_refinement';
import type { Lattice } from './lattice';
import { OutsideMap } from './outside';
import { coordinates, sub } from './vec';

const ONE_KNOT = 2 ** -40; // of the range of an axis: nearer knots are one

export class Summand {
  private readonly outside: OutsideMap;
  private readonly rest: Float64Array;
  private readonly rows: readonly RefinedPoint[][];

  /** @param sum The structure of a sum that this lattice is part of. */
  constructor(readonly structure: LatticeStructure, sum: LatticeStructure) {
    this.outside = new OutsideMap(structure);
    const { continued } = this.outside;
    this.rest = identityPoints(continued);
    this.rows = AXES.map((axis) => {
      const target = { degree: sum.degree[axis], knots: Array.from(sum.knots[axis]) };
      return refine(placed(continued, sum, axis), target);
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

/** An axis of a lattice in the parameter of the sum, with knots that are the sum's to the bit. */
function placed(lattice: LatticeStructure, sum: LatticeStructure, axis: Axis): AxisSpace {
  const edges = frameEdges(sum.frame);
  const [first, last] = domain(sum, axis), [begin, end] = domain(lattice, axis);
  const at = first + (last - first) * coordinates(edges, sub(lattice.frame.origin, sum.frame.origin))[axis];
  const scale = ((last - first) * coordinates(edges, frameEdges(lattice.frame)[axis])[axis]) / (end - begin);
  const near = ONE_KNOT * (last - first);
  const knots = Array.from(lattice.knots[axis], (knot) => {
    const own = at + scale * (knot - begin);
    return sum.knots[axis].find((other) => Math.abs(other - own) <= near) ?? own;
  });
  return { degree: lattice.degree[axis], knots };
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

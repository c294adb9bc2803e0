// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The deformation R(u,v,w) = sum over i,j,k of P_ijk N_i(u) N_j(v) N_k(w), in double.
import type { Lattice__Output } from './generated/latticed/v1/Lattice.js';

// One axis. Distinct knots of the domain cut it into spans.
class Axis {
  private readonly begins: number[];  // for each span, the last knot that it begins at

  constructor(private readonly knots: readonly number[], private readonly degree: number) {
    const inner = knots.map((_, i) => i).slice(degree, -degree - 1);
    this.begins = inner.filter((i) => knots[i]! < knots[i + 1]!);
  }

  /** The first basis function that may differ from 0 in a span, and the values of this one and the next ones, at a
      local coordinate from -1/2 to 1/2: The NURBS Book, A2.2. */
  basis(span: number, local: number): { first: number; values: number[] } {
    const { knots } = this;
    const begin = this.begins[span]!;
    const low = knots[begin]!, high = knots[begin + 1]!;
    const u = (low + high) / 2 + local * (high - low);
    let values = [1];
    for (let p = 1; p <= this.degree; ++p) {
      const raised = Array<number>(p + 1).fill(0);
      values.forEach((value, r) => {
        const right = knots[begin + r + 1]!, left = knots[begin + r + 1 - p]!;
        const share = value / (right - left);
        raised[r]! += (right - u) * share;
        raised[r + 1]! += (u - left) * share;
      });
      values = raised;
    }
    return { first: begin - this.degree, values };
  }
}

export class BsplineVolume {
  private readonly axes: readonly [Axis, Axis, Axis];
  private readonly row: number;    // control points of the first axis
  private readonly layer: number;  // of the first two axes

  constructor(private readonly lattice: Lattice__Output) {
    const { degree, size, knotsU, knotsV, knotsW } = lattice;
    this.axes = [new Axis(knotsU, degree!.u), new Axis(knotsV, degree!.v), new Axis(knotsW, degree!.w)];
    this.row = size!.u;
    this.layer = size!.u * size!.v;
  }

  /** The point with these local coordinates in the box of these spans. */
  at(spans: readonly number[], local: readonly number[]): [number, number, number] {
    const [u, v, w] = this.axes.map((axis, a) => axis.basis(spans[a]!, local[a]!));
    const point: [number, number, number] = [0, 0, 0];
    w!.values.forEach((nw, k) => v!.values.forEach((nv, j) => u!.values.forEach((nu, i) => {
      const index = u!.first + i + this.row * (v!.first + j) + this.layer * (w!.first + k);
      for (const c of [0, 1, 2] as const) point[c] += nu * nv * nw * this.lattice.controlPoints[3 * index + c]!;
    })));
    return point;
  }
}

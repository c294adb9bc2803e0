// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { AXES, type Axis, type LatticeStructure } from '../lattice/grid';

/** A span of an axis: between two distinct knots of the domain that follow each other. */
export interface Span {
  /** Number of the first control point on this axis that has an effect; degree + 1 have one. */
  readonly firstPoint: number;
  /** In the domain. */
  readonly width: number;
  /** In the domain, from its begin. */
  readonly middle: number;
  /** factors[p][i]: the factor of l^p in the basis function of control point firstPoint + i, with l from -1/2 to 1/2. */
  readonly factors: readonly (readonly number[])[];
}

/** The spans of all three axes, in double. */
export function spansOf(lattice: LatticeStructure): [Span[], Span[], Span[]] {
  return AXES.map((axis) => spansOfAxis(lattice, axis)) as [Span[], Span[], Span[]];
}

function spansOfAxis(lattice: LatticeStructure, axis: Axis): Span[] {
  const knots = lattice.knots[axis];
  const degree = lattice.degree[axis];
  const spans: Span[] = [];
  for (let at = degree; at < lattice.size[axis]; ++at) {
    const width = knots[at + 1]! - knots[at]!;
    if (width > 0) spans.push({ firstPoint: at - degree, width, middle: (knots[at]! + knots[at + 1]!) / 2 - knots[degree]!, factors: basisPolynomials(knots, degree, at) });
  }
  return spans;
}

/** De Boor's recurrence (lattice/bspline.ts) on polynomials in l: t = middle + width l in the interval `at` of knots. */
function basisPolynomials(knots: Float64Array, degree: number, at: number): number[][] {
  const width = knots[at + 1]! - knots[at]!;
  const middle = knots[at]! + width / 2;
  let basis: number[][] = [[1]];
  for (let d = 1; d <= degree; ++d) {
    const next: number[][] = Array.from({ length: d + 1 }, () => new Array<number>(d + 1).fill(0));
    for (let r = 0; r < d; ++r) {
      const upper = knots[at + r + 1]!;
      const lower = knots[at + 1 - d + r]!;
      basis[r]!.forEach((factor, p) => {
        const term = factor / (upper - lower);
        next[r]![p]! += term * (upper - middle);
        next[r]![p + 1]! -= term * width;
        next[r + 1]![p]! += term * (middle - lower);
        next[r + 1]![p + 1]! += term * width;
      });
    }
    basis = next;
  }
  return Array.from({ length: degree + 1 }, (_, p) => basis.map((polynomial) => polynomial[p]!));
}

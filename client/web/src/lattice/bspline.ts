// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The volume R(u,v,w) = sum_ijk P_ijk N_i(u) N_j(v) N_k(w) in double (Cui & Feng 2014, formula (1)). The page evaluates
// only a few points itself: the edges of knot boxes.

import { AXES, domain, type Axis } from './grid';
import type { Lattice } from './lattice';
import type { MutableVec3, Vec3 } from './vec';

/** The knot interval of t: knots[i] <= t < knots[i + 1]. The end of the domain belongs to the last interval. */
export function findSpan(knots: ArrayLike<number>, degree: number, size: number, t: number): number {
  let span = degree;
  while (span < size - 1 && t >= knots[span + 1]) ++span;
  return span;
}

/** The degree + 1 basis functions that are not zero in `span`, at t (de Boor's recurrence). */
export function basisFunctions(knots: ArrayLike<number>, degree: number, span: number, t: number): number[] {
  const basis = [1];
  for (let d = 1; d <= degree; ++d) {
    let saved = 0;
    for (let r = 0; r < d; ++r) {
      const right = knots[span + r + 1] - t;
      const left = t - knots[span + 1 - d + r];
      const term = basis[r] / (right + left);
      basis[r] = saved + right * term;
      saved = left * term;
    }
    basis[d] = saved;
  }
  return basis;
}

/** The deformed position of a point of the knot domain. */
export function evaluate(lattice: Lattice, parameter: Vec3): Vec3 {
  const { degree, size, knots, points } = lattice;
  const spans = AXES.map((a) => findSpan(knots[a], degree[a], size[a], parameter[a]));
  const bases = AXES.map((a) => basisFunctions(knots[a], degree[a], spans[a], parameter[a]));
  const sum: MutableVec3 = [0, 0, 0];
  for (let k = 0; k <= degree[2]; ++k) {
    for (let j = 0; j <= degree[1]; ++j) {
      for (let i = 0; i <= degree[0]; ++i) {
        const weight = bases[0][i] * bases[1][j] * bases[2][k];
        const u = spans[0] - degree[0] + i;
        const at = 3 * (u + size[0] * (spans[1] - degree[1] + j + size[1] * (spans[2] - degree[2] + k)));
        for (const axis of AXES) sum[axis] += weight * points[at + axis];
      }
    }
  }
  return sum;
}

/** The distinct knots of the domain, with both ends: the planes between knot boxes. */
export function knotPlanes(lattice: Lattice, axis: Axis): number[] {
  const [begin, end] = domain(lattice, axis);
  return [...new Set(Array.from(lattice.knots[axis]).filter((knot) => knot >= begin && knot <= end))];
}

/** The deformed edges of all knot boxes as a line list, x y z per end; `steps` lines per edge. */
export function knotBoxLines(lattice: Lattice, steps: number): Float64Array {
  const planes = AXES.map((axis) => knotPlanes(lattice, axis));
  const lines: number[] = [];
  for (const along of AXES) {
    const [a, b] = AXES.filter((axis) => axis !== along) as [Axis, Axis];
    const stops = subdivided(planes[along], steps);
    for (const s of planes[a]) {
      for (const t of planes[b]) {
        const curve = stops.map((r) => {
          const parameter: MutableVec3 = [0, 0, 0];
          parameter[along] = r;
          parameter[a] = s;
          parameter[b] = t;
          return evaluate(lattice, parameter);
        });
        for (let i = 0; i + 1 < curve.length; ++i) lines.push(...curve[i], ...curve[i + 1]);
      }
    }
  }
  return Float64Array.from(lines);
}

function subdivided(stops: readonly number[], steps: number): number[] {
  const fine: number[] = [stops[0]];
  for (let i = 0; i + 1 < stops.length; ++i) {
    for (let s = 1; s <= steps; ++s) fine.push(stops[i] + ((stops[i + 1] - stops[i]) * s) / steps);
  }
  return fine;
}

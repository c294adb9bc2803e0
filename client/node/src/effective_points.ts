// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The control points by which a scene is deformed at its strength s: rest + s (P - rest), with rest, the Greville points of
// the lattice.
import type { LatticeState__Output } from './generated/latticed/v1/LatticeState.js';
import type { Vec3__Output } from './generated/latticed/v1/Vec3.js';

/** x y z of each, u fastest. */
export function effectivePoints({ lattice, strength = 1 }: LatticeState__Output): number[] {
  const { controlPoints, degree, knotsU, knotsV, knotsW, frame } = lattice!;
  if (strength === 1) return controlPoints;
  const [u, v, w] = [places(knotsU, degree!.u), places(knotsV, degree!.v), places(knotsW, degree!.w)];
  const { origin, u: edgeU, v: edgeV, w: edgeW } = frame!;
  const rest = w.flatMap((c) => v.flatMap((b) => u.flatMap((a) =>
    (['x', 'y', 'z'] as const).map((axis) => at(axis, origin!, edgeU!, edgeV!, edgeW!, a, b, c)))));
  return controlPoints.map((x, i) => rest[i]! + strength * (x - rest[i]!));
}

function at(axis: 'x' | 'y' | 'z', origin: Vec3__Output, u: Vec3__Output, v: Vec3__Output, w: Vec3__Output, a: number, b: number, c: number): number {
  return origin[axis] + a * u[axis] + b * v[axis] + c * w[axis];
}

/** The Greville abscissae of an axis, as parts of its domain. */
function places(knots: readonly number[], degree: number): number[] {
  const count = knots.length - degree - 1;
  const begin = knots[degree]!, length = knots[count]! - begin;
  return Array.from({ length: count }, (_, i) => {
    const mean = knots.slice(i + 1, i + 1 + degree).reduce((sum, knot) => sum + knot, 0) / degree;
    return (mean - begin) / length;
  });
}

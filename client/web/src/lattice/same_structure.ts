// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { AXES, frameEdges, type LatticeStructure } from './grid';

/** Whether two lattices differ in their control points at most. */
export function sameStructure(a: LatticeStructure, b: LatticeStructure): boolean {
  const equal = (x: ArrayLike<number>, y: ArrayLike<number>): boolean =>
    x.length === y.length && Array.from(x).every((v, i) => v === y[i]);
  return (
    equal(a.degree, b.degree) &&
    equal(a.size, b.size) &&
    equal(a.frame.origin, b.frame.origin) &&
    AXES.every((axis) => equal(a.knots[axis], b.knots[axis]) && equal(frameEdges(a.frame)[axis], frameEdges(b.frame)[axis]))
  );
}

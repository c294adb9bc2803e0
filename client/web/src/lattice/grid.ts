// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The grid of control points: axes, places, counts and limits.
import type { Lattice, LatticeFrame } from './lattice';
import type { Basis } from './vec';

/** A lattice without its control points. */
export type LatticeStructure = Pick<Lattice, 'frame' | 'degree' | 'size' | 'knots' | 'outside'>;

/** One integer per axis u, v, w. */
export type Axes = readonly [number, number, number];

/** An axis of the lattice: 0 is u, 1 is v, 2 is w. */
export type Axis = 0 | 1 | 2;

export const AXES: readonly Axis[] = [0, 1, 2];
export const AXIS_NAMES = ['u', 'v', 'w'] as const;

/** The server's limits on a lattice. */
export const MAX_CONTROL_POINTS = 32768;
export const MAX_DEGREE = 3;

export function pointCount(size: Axes): number {
  return size[0] * size[1] * size[2];
}

export function indexOf(size: Axes, [i, j, k]: Axes): number {
  return i + size[0] * (j + size[1] * k);
}

/** The place (i,j,k) of a control point in the grid. */
export function placeOf(size: Axes, index: number): [number, number, number] {
  const row = Math.floor(index / size[0]);
  return [index % size[0], row % size[1], Math.floor(row / size[1])];
}

/** The three edge vectors of a rest lattice. */
export function frameEdges(frame: LatticeFrame): Basis {
  return [frame.u, frame.v, frame.w];
}

/** Begin and end of the knot domain of an axis. */
export function domain({ knots, degree, size }: LatticeStructure, axis: Axis): [number, number] {
  return [knots[axis][degree[axis]], knots[axis][size[axis]]];
}

/** Says in words why no lattice can have this size and degree; undefined if one can. */
export function refusalOfAxes(size: Axes, degree: Axes): string | undefined {
  for (const axis of AXES) {
    const name = AXIS_NAMES[axis];
    if (!Number.isInteger(degree[axis]) || degree[axis] < 1 || degree[axis] > MAX_DEGREE) {
      return `The degree along ${name} is 1, 2 or 3.`;
    }
    if (!Number.isInteger(size[axis]) || size[axis] <= degree[axis]) {
      return `Along ${name}, degree ${degree[axis]} needs at least ${degree[axis] + 1} control points.`;
    }
  }
  const count = pointCount(size);
  if (count > MAX_CONTROL_POINTS) {
    return `${count.toLocaleString('en')} control points are too many: at most ${MAX_CONTROL_POINTS.toLocaleString('en')}.`;
  }
  return undefined;
}

/** Whether two lattices are equal except for their control points. */
export function sameStructure(a: LatticeStructure, b: LatticeStructure): boolean {
  const equal = (x: ArrayLike<number>, y: ArrayLike<number>): boolean =>
    x.length === y.length && Array.from(x).every((v, i) => v === y[i]);
  return (
    equal(a.degree, b.degree) &&
    equal(a.size, b.size) &&
    equal(a.frame.origin, b.frame.origin) &&
    a.outside?.mode === b.outside?.mode &&
    a.outside?.smooth === b.outside?.smooth &&
    equal(a.outside?.widths ?? [], b.outside?.widths ?? []) &&
    equal(a.outside?.steps ?? [], b.outside?.steps ?? []) &&
    AXES.every((axis) => equal(a.knots[axis], b.knots[axis]) && equal(frameEdges(a.frame)[axis], frameEdges(b.frame)[axis]))
  );
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lattice at rest. Its control points are at the Greville abscissae of the frame, which do not deform the mesh.

import { AXES, domain, frameEdges, pointCount, type Axes, type Axis, type LatticeStructure } from './grid';
import { Lattice, type LatticeFrame, type Outside } from './lattice';
import { add, scale, type Vec3 } from './vec';

export interface Fit {
  size: Axes;
  degree: Axes;
  /** Margin on every side of each axis, as a fraction of the longest edge of the bounds. */
  padding: number;
  /** Absent: points outside stay. */
  outside?: Outside | undefined;
}

/** The server's default. */
export const DEFAULT_FIT: Fit = { size: [4, 4, 4], degree: [2, 2, 2], padding: 0.05 };

/** 0 and size - degree repeated degree + 1 times at the ends, and the integers between. */
export function clampedUniformKnots(degree: number, size: number): Float64Array {
  const last = size - degree;
  return Float64Array.from({ length: size + degree + 1 }, (_, i) => Math.min(Math.max(i - degree, 0), last));
}

/** Means of `degree` consecutive knots: the rest positions of control points along an axis. */
export function grevilleAbscissae(knots: ArrayLike<number>, degree: number, size: number): number[] {
  return Array.from({ length: size }, (_, i) => {
    let sum = 0;
    for (let k = 1; k <= degree; ++k) sum += knots[i + k];
    return sum / degree;
  });
}

/** Maps a point of the knot domain to the world by the rest lattice's frame, to the same bits as the server. */
export function restPosition(structure: LatticeStructure, parameter: Vec3): Vec3 {
  let p = structure.frame.origin;
  for (const axis of AXES) {
    const [begin, end] = domain(structure, axis);
    const [x, y, z] = frameEdges(structure.frame)[axis];
    const length = end - begin;
    p = add(p, scale([x / length, y / length, z / length], parameter[axis] - begin));
  }
  return p;
}

export function identityPoints(structure: LatticeStructure): Float64Array {
  const { knots, degree, size } = structure;
  const [us, vs, ws] = AXES.map((a) => grevilleAbscissae(knots[a], degree[a], size[a])) as [number[], number[], number[]];
  const points = new Float64Array(3 * pointCount(size));
  let at = 0;
  for (const w of ws) {
    for (const v of vs) {
      for (const u of us) {
        points.set(restPosition(structure, [u, v, w]), at);
        at += 3;
      }
    }
  }
  return points;
}

/** A lattice at rest with another size and degree. An axis that keeps both keeps its knots; others get uniform ones. */
export function resized(before: LatticeStructure, size: Axes, degree: Axes): Lattice {
  const { frame, outside } = before;
  const isKept = (axis: Axis): boolean => size[axis] === before.size[axis] && degree[axis] === before.degree[axis];
  const knots = knotVectors((axis) => (isKept(axis) ? before.knots[axis] : clampedUniformKnots(degree[axis], size[axis])));
  return new Lattice(frame, degree, size, knots, identityPoints({ frame, degree, size, knots }), outside);
}

/** A lattice at rest in a frame, with uniform knots. */
export function latticeAtRest(frame: LatticeFrame, size: Axes, degree: Axes, outside?: Outside): Lattice {
  const knots = knotVectors((axis) => clampedUniformKnots(degree[axis], size[axis]));
  return new Lattice(frame, degree, size, knots, identityPoints({ frame, degree, size, knots }), outside);
}

/** One knot vector per axis. */
export function knotVectors(of: (axis: 0 | 1 | 2) => Float64Array): LatticeStructure['knots'] {
  return [of(0), of(1), of(2)];
}

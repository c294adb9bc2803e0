// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A lattice as the parent of another one, whose control points it carries where it moves the world (CarryControlPoints).
import { AXES, frameEdges } from './grid';
import { identityPoints } from './identity';
import type { Lattice } from './lattice';
import { OutsideMap } from './outside';
import { coordinates, pointAt, sub } from './vec';

const SNAP = 2 ** -40; // of an edge: points this close to a face are inside, as kPlaneSnap of the server

/** Whether it moves nothing. */
export function isAtRest(lattice: Lattice): boolean {
  return lattice.strength === 0 || identityPoints(lattice).every((x, i) => x === lattice.points[i]);
}

/** Which of these control points, x y z each, a parent carries: those in its frame, and in what goes on outside of it. */
export function carriedBy(parent: Lattice, points: Float64Array, indices: readonly number[]): number[] {
  const { frame } = new OutsideMap(parent).continued;
  const edges = frameEdges(frame);
  return indices.filter((index) => {
    const at = coordinates(edges, sub(pointAt(points, index), frame.origin));
    return AXES.every((axis) => at[axis] >= -SNAP && at[axis] <= 1 + SNAP);
  });
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The point and the axes of a transform.

import { frameEdges } from '../lattice/grid';
import type { Lattice } from '../lattice/lattice';
import { WORLD_BASIS, add, normalized, pointAt, scale, type Basis, type Vec3 } from '../lattice/vec';

/** 'each': every selected point is its own pivot. Turns and scalings then move only soft-selected points. */
export type Pivot = 'median' | 'active' | 'each';
export type Orientation = 'world' | 'lattice' | 'view';

/** The pivot's position. For 'each' it is the median, where the gizmo stands. */
export function pivotPoint(
  points: ArrayLike<number>,
  indices: Uint32Array,
  pivot: Pivot,
  active: number | undefined,
): Vec3 {
  if (pivot === 'active' && active !== undefined) return pointAt(points, active);
  let sum: Vec3 = [0, 0, 0];
  for (const index of indices) sum = add(sum, pointAt(points, index));
  return scale(sum, 1 / Math.max(indices.length, 1));
}

/** The unit vectors of X, Y and Z. `view` is right, up and towards the viewer. */
export function orientationBasis(orientation: Orientation, lattice: Lattice, view: Basis): Basis {
  switch (orientation) {
    case 'world':
      return WORLD_BASIS;
    case 'lattice':
      return frameEdges(lattice.frame).map(normalized) as unknown as Basis;
    case 'view':
      return view;
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { AXES } from './grid';
import { latticeAtRest, type Fit } from './identity';
import type { Lattice, Vec3 } from './lattice';

/** The lattice that the server fits around a mesh with these bounds, along the world axes. */
export function fitLattice(bounds: { min: Vec3; max: Vec3 }, { size, degree, padding, outside }: Fit): Lattice {
  const extent = AXES.map((a) => bounds.max[a] - bounds.min[a]);
  const margin = padding * (Math.max(...extent) || 1);
  const [x, y, z] = extent.map((length) => length + 2 * margin);
  const origin = AXES.map((a) => bounds.min[a] - margin) as unknown as Vec3;
  const frame = { origin, u: [x, 0, 0], v: [0, y, 0], w: [0, 0, z] } as const;
  return latticeAtRest(frame, size, degree, outside);
}

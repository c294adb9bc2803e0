// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { AXES, domain, frameEdges, type LatticeStructure } from '../lattice/grid';
import { cross, dot, length, scale, type Vec3 } from '../lattice/vec';

/**
 * The world position's change at rest per unit of the domain along each axis, all negative in a left-handed frame (patches.proto,
 * Normals). Divided by the largest of them, since only directions count and float32 must not overflow.
 */
export function conormals(structure: LatticeStructure): [Vec3, Vec3, Vec3] {
  const edges = frameEdges(structure.frame);
  const sign = Math.sign(dot(edges[0], cross(edges[1], edges[2]))) || 1;
  const changes = AXES.map((axis) => {
    const [begin, end] = domain(structure, axis);
    return scale(edges[axis], sign / (end - begin));
  });
  const largest = Math.max(...changes.map(length));
  return changes.map((change) => scale(change, 1 / largest)) as [Vec3, Vec3, Vec3];
}

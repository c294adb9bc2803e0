// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { frameEdges, type Axis } from './grid';
import { Lattice } from './lattice';
import { add, combine, coordinates, length, normalized, scale, sub, pointAt, type Basis, type Vec3 } from './vec';

/**
 * A rectangular lattice whose control points are twisted and then bent about the longest edge of its frame (Barr 1984).
 *
 * With x along that edge from its middle, y and z along the next two, L its length, t = x / L: y and z are turned by
 * `twist` t. Then the middle line becomes an arc of radius R = L / `bend`:
 *
 *   x -> (R - z) sin(bend t),   z -> R - (R - z) cos(bend t)
 *
 * Angles are in radians; a bend of 0 leaves the line straight.
 */
export function bentLattice(rest: Lattice, twist: number, bend: number): Lattice {
  const edges = frameEdges(rest.frame);
  const lengths = edges.map(length);
  const along = lengths.indexOf(Math.max(...lengths)) as Axis;
  const axes = [0, 1, 2].map((i) => normalized(edges[(along + i) % 3])) as unknown as Basis;
  const middle = add(rest.frame.origin, scale(combine(edges, [1, 1, 1]), 0.5));
  const points = rest.points.slice();
  for (let i = 0; i < rest.count; ++i) {
    const [x, y, z] = coordinates(axes, sub(pointAt(points, i), middle));
    const t = x / lengths[along];
    const [c, s] = [Math.cos(twist * t), Math.sin(twist * t)];
    points.set(add(middle, combine(axes, onArc([x, c * y - s * z, s * y + c * z], t, lengths[along], bend))), 3 * i);
  }
  return new Lattice(rest.frame, rest.degree, rest.size, rest.knots, points);
}

function onArc([x, y, z]: Vec3, t: number, along: number, bend: number): Vec3 {
  if (bend === 0) return [x, y, z];
  const radius = along / bend;
  return [(radius - z) * Math.sin(bend * t), y, radius - (radius - z) * Math.cos(bend * t)];
}

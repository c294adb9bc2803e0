// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One knot box: its control points; deformed, its twelve edges as lines and its six faces as triangles.
import { evaluate, knotPlanes } from './bspline';
import { AXES, indexOf, type Axis, type LatticeStructure } from './grid';
import type { Lattice } from './lattice';
import type { MutableVec3, Vec3 } from './vec';

/** Numbers of a box on u, v and w, from 0, among knot intervals that are not empty. */
export type BoxPlace = readonly [u: number, v: number, w: number];

export interface BoxGrid {
  /** Two ends for each line. */
  readonly edges: Vec3[];
  /** Three corners for each triangle. */
  readonly triangles: Vec3[];
}

/** The control points that influence the box. None if the lattice has no such box. */
export function pointsOfBox({ knots, degree, size }: LatticeStructure, box: BoxPlace): number[] {
  const firsts = AXES.map((axis) => {
    const spans: number[] = [];
    for (let span = degree[axis]; span < size[axis]; ++span) if (knots[axis][span] < knots[axis][span + 1]) spans.push(span);
    return (spans[box[axis]] ?? -1) - degree[axis];
  });
  const points: number[] = [];
  if (firsts.some((first) => first < 0)) return points;
  const [u, v, w] = firsts as [number, number, number];
  for (let k = w; k <= w + degree[2]; ++k) {
    for (let j = v; j <= v + degree[1]; ++j) {
      for (let i = u; i <= u + degree[0]; ++i) points.push(indexOf(size, [i, j, k]));
    }
  }
  return points;
}

/** Each edge has `steps` lines, each face 2 steps² triangles. Nothing if the lattice has no such box. */
export function boxGrid(lattice: Lattice, box: BoxPlace, steps: number): BoxGrid {
  const grid: BoxGrid = { edges: [], triangles: [] };
  const stops = AXES.map((axis) => {
    const planes = knotPlanes(lattice, axis);
    const [begin, end] = [planes[box[axis]], planes[box[axis] + 1]];
    return begin === undefined || end === undefined
      ? []
      : Array.from({ length: steps + 1 }, (_, i) => begin + ((end - begin) * i) / steps);
  });
  if (stops.some(({ length }) => length === 0)) return grid;
  for (const across of AXES) {
    const [a, b] = [((across + 1) % 3) as Axis, ((across + 2) % 3) as Axis];
    for (const side of [0, steps]) {
      const at = (i: number, j: number): Vec3 => {
        const parameter: MutableVec3 = [0, 0, 0];
        parameter[across] = stops[across][side];
        parameter[a] = stops[a][i];
        parameter[b] = stops[b][j];
        return evaluate(lattice, parameter);
      };
      const points = stops[a].map((_, i) => stops[b].map((_, j) => at(i, j)));
      for (let i = 0; i < steps; ++i) {
        for (let j = 0; j < steps; ++j) {
          const [p, q, r, s] = [points[i][j], points[i + 1][j], points[i + 1][j + 1], points[i][j + 1]];
          grid.triangles.push(p, q, r, p, r, s);
        }
        for (const j of [0, steps]) grid.edges.push(points[i][j], points[i + 1][j]);
      }
    }
  }
  return grid;
}

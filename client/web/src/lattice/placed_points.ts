// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Many points of the rest shape in a lattice. Their basis functions are computed once, and used for each edit.
import { basisFunctions, findSpan } from './bspline';
import { AXES, domain, frameEdges, type LatticeStructure } from './grid';
import { coordinates, pointAt, sub, type Vec3 } from './vec';

const MOST_BASIS = 4; // basis functions per axis, for degree 3
const SNAP = 1e-6; // points this close to a face of the frame are on it: their coordinates come as float32

export class PlacedPoints {
  /** Per point, the first control point of its knot box; -1 outside the frame. */
  private readonly firsts: Int32Array;
  /** Per point and axis, the basis functions there. */
  private readonly bases: Float64Array;

  /** @param points World positions at rest, x y z each. */
  constructor(private readonly structure: LatticeStructure, private readonly points: Float64Array) {
    this.firsts = new Int32Array(points.length / 3);
    this.bases = new Float64Array(3 * MOST_BASIS * this.firsts.length);
    for (let i = 0; i < this.firsts.length; ++i) this.firsts[i] = this.place(i);
  }

  /** Where the lattice moves each point, R(u,v,w) of bspline.ts. Points outside the frame stay. */
  deformed(controlPoints: Float64Array): Float64Array {
    const out = this.points.slice();
    const { degree, size } = this.structure;
    const [row, plane] = [3 * size[0], 3 * size[0] * size[1]];
    for (let i = 0; i < this.firsts.length; ++i) {
      const first = this.firsts[i];
      if (first < 0) continue;
      const basis = 3 * MOST_BASIS * i;
      let [x, y, z] = [0, 0, 0];
      for (let c = 0; c <= degree[2]; ++c) {
        for (let b = 0; b <= degree[1]; ++b) {
          const across = this.bases[basis + 2 * MOST_BASIS + c] * this.bases[basis + MOST_BASIS + b];
          let at = 3 * first + c * plane + b * row;
          for (let a = 0; a <= degree[0]; ++a, at += 3) {
            const weight = across * this.bases[basis + a];
            x += weight * controlPoints[at];
            y += weight * controlPoints[at + 1];
            z += weight * controlPoints[at + 2];
          }
        }
      }
      out[3 * i] = x;
      out[3 * i + 1] = y;
      out[3 * i + 2] = z;
    }
    return out;
  }

  private place(point: number): number {
    const { frame, knots, degree, size } = this.structure;
    const fractions = coordinates(frameEdges(frame), sub(pointAt(this.points, point), frame.origin));
    if (fractions.some((x) => !(x >= -SNAP && x <= 1 + SNAP))) return -1;
    const spans = AXES.map((axis) => {
      const [begin, end] = domain(this.structure, axis);
      const t = begin + Math.min(Math.max(fractions[axis], 0), 1) * (end - begin);
      const span = findSpan(knots[axis], degree[axis], size[axis], t);
      this.bases.set(basisFunctions(knots[axis], degree[axis], span, t), MOST_BASIS * (3 * point + axis));
      return span - degree[axis];
    }) as unknown as Vec3;
    return spans[0] + size[0] * (spans[1] + size[1] * spans[2]);
  }
}

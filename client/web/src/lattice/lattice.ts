// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Three world coordinates, or one number per axis. */
export type Vec3 = readonly [number, number, number];

/** The parallelepiped of the knot domain, from `origin` to `origin + u + v + w`. World units. */
export interface LatticeFrame {
  readonly origin: Vec3;
  readonly u: Vec3;
  readonly v: Vec3;
  readonly w: Vec3;
}

/** How a lattice goes on outside its frame. */
export interface Outside {
  readonly mode: 'falloff' | 'linear';
  /** Of a falloff: whether normals, too, go on through the faces. */
  readonly smooth: boolean;
  /** How far it goes on, in lengths of the frame's edges: at the begin and end of u, of v, of w. 0: points outside stay. */
  readonly widths: readonly number[];
  /** Of a falloff: how far from each face its inner knot plane is. Empty: not yet chosen by the server. */
  readonly steps: readonly number[];
}

/**
 * A B-spline volume R(u,v,w) = sum over ijk of P_ijk N_i(u) N_j(v) N_k(w).
 *
 * Control point (i, j, k) has the index `i + size[0] * (j + size[1] * k)`. Its x, y, z begin at 3 times the index.
 */
export class Lattice {
  constructor(
    readonly frame: LatticeFrame,
    /** Per axis, 1 to 3. */
    readonly degree: Vec3,
    /** Control points per axis. */
    readonly size: Vec3,
    /** Knots per axis, `size + degree + 1` of each. */
    readonly knots: readonly [Float64Array, Float64Array, Float64Array],
    /** Control points in world units, x y z each. Changed in place by edits. */
    readonly points: Float64Array,
    /** How it goes on outside the frame; undefined: points outside stay. */
    readonly outside?: Outside,
    /** How much of its deformation the scene takes, 0 to 1. Changed in place by edits. */
    public strength = 1,
  ) {}

  /** Number of control points. */
  get count(): number {
    return this.size[0] * this.size[1] * this.size[2];
  }

  /** The same lattice with its own copy of the control points. */
  clone(): Lattice {
    return new Lattice(this.frame, this.degree, this.size, this.knots, this.points.slice(), this.outside, this.strength);
  }
}

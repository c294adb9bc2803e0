// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from '../../lattice/vec';
import { MOST_LEVEL } from '../../surface/patches/adaptive_pattern';
import type { PatchPlan } from '../plan/patch_plan';
import { bendOf, levelOf, shrinkOf, UNKNOWN_BEND } from './edge_levels';

/** How far points may be from the surface, seen from an eye: `perDistance` times the distance, or `everywhere` the same. */
export type SeenTolerance =
  | { readonly eye: Vec3; readonly perDistance: number; readonly nearest: number }
  | { readonly everywhere: number };

/**
 * The levels of all edges for a tolerance that depends on the distance of an edge's patches from the eye. An edge takes the least
 * tolerance of its patches. While a camera moves, a level that is finer than needed by one stays, so that little changes.
 */
export class ChosenLevels {
  readonly levels: Uint8Array;
  private readonly tolerances: Float64Array;

  constructor(private readonly plan: PatchPlan) {
    this.levels = new Uint8Array(plan.edgeCount);
    this.tolerances = new Float64Array(plan.edgeCount);
  }

  /**
   * @param bytes Of all edges.
   * @param positions Of all vertices, relative to the plan's origin.
   * @param isLazy Whether levels that are finer than needed by one stay.
   */
  choose(bytes: Uint8Array, positions: Float64Array, seen: SeenTolerance, isLazy: boolean): void {
    this.measure(bytes, positions, seen);
    const { levels, tolerances } = this;
    const unit = this.plan.curvatureUnit;
    const bends = Float64Array.from({ length: 256 }, (_, byte) => bendOf(byte, unit));
    for (let edge = 0; edge < levels.length; ++edge) {
      const level = levelOf(bends[bytes[edge]!]!, tolerances[edge]!);
      if (!(isLazy && levels[edge] === level + 1)) levels[edge] = level;
    }
  }

  /** The largest distance of triangles from the surface that the levels allow, in world units; Infinity if an edge is unknown. */
  error(bytes: Uint8Array): number {
    const { levels } = this;
    const unit = this.plan.curvatureUnit;
    const shrinks = Float64Array.from({ length: MOST_LEVEL + 1 }, (_, level) => shrinkOf(level));
    const bends = Float64Array.from({ length: 256 }, (_, byte) => bendOf(byte, unit));
    let largest = 0;
    for (let edge = 0; edge < levels.length; ++edge) largest = Math.max(largest, bends[bytes[edge]!]! * shrinks[levels[edge]!]!);
    return largest;
  }

  private measure(bytes: Uint8Array, positions: Float64Array, seen: SeenTolerance): void {
    const { tolerances } = this;
    const { corners, edges, origin, curvatureUnit } = this.plan;
    if ('everywhere' in seen) return void tolerances.fill(seen.everywhere);
    tolerances.fill(Infinity);
    const [x, y, z] = [0, 1, 2].map((axis) => seen.eye[axis]! - origin[axis]!) as [number, number, number];
    const distances = new Float64Array(positions.length / 3);
    for (let vertex = 0, at = 0; vertex < distances.length; ++vertex, at += 3) {
      distances[vertex] = Math.sqrt((positions[at]! - x) ** 2 + (positions[at + 1]! - y) ** 2 + (positions[at + 2]! - z) ** 2);
    }
    // A patch is nearer than its nearest corner by no more than its size, and by what it bends. What is not known has the finest
    // levels anyway.
    const bulges = Float64Array.from({ length: 256 }, (_, byte) => (byte === UNKNOWN_BEND ? 0 : bendOf(byte, curvatureUnit) / 6));
    for (let at = 0; at < corners.length; at += 3) {
      const [a, b, c] = [corners[at]!, corners[at + 1]!, corners[at + 2]!];
      const bulge = Math.max(bulges[bytes[edges[at]!]!]!, bulges[bytes[edges[at + 1]!]!]!, bulges[bytes[edges[at + 2]!]!]!);
      const nearest = Math.min(distances[a]!, distances[b]!, distances[c]!) - sizeOf(positions, a, b, c) - bulge;
      const tolerance = seen.perDistance * Math.max(nearest, seen.nearest);
      for (let e = at; e < at + 3; ++e) if (tolerance < tolerances[edges[e]!]!) tolerances[edges[e]!] = tolerance;
    }
  }
}

/** The diagonal of the box around three vertices. */
function sizeOf(positions: Float64Array, a: number, b: number, c: number): number {
  let square = 0;
  for (let axis = 0; axis < 3; ++axis) {
    const [p, q, r] = [positions[3 * a + axis]!, positions[3 * b + axis]!, positions[3 * c + axis]!];
    square += (Math.max(p, q, r) - Math.min(p, q, r)) ** 2;
  }
  return Math.sqrt(square);
}

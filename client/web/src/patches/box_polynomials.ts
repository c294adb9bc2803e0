// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { AXES, domain, frameEdges, placeOf, type LatticeStructure } from '../lattice/grid';
import { scale, sub, type Vec3 } from '../lattice/vec';
import { KNOT, type PatchPlan } from './plan/patch_plan';
import { spansOf, type Span } from './span_basis';

/**
 * The polynomial of each knot box in l_0, l_1, l_2 from -1/2 to 1/2, relative to the plan's origin: computed in double from the
 * control points, and rounded once. Box 0 is the outside box, which is a polynomial of degree 1.
 *
 *   numbers   x y z w per coefficient; its place in the box, and what w is: evaluate_patch.vert
 *   boxes     outside, then 1 + span_0 + spans_0 (span_1 + spans_1 span_2)
 */
export class BoxPolynomials {
  readonly numbers: Float32Array;
  /** Coefficients of a box. */
  readonly perBox: number;
  /** By how much a box's number rises with the span on each axis. */
  readonly steps: Vec3;
  readonly boxCount: number;
  private readonly spans: readonly [Span[], Span[], Span[]];
  private readonly isStale: Uint8Array;
  /** Powers on each axis, 0 included. */
  readonly terms: readonly [number, number, number];
  /** The world position's change at rest per unit of the domain along each axis. */
  readonly restEdges: readonly [Vec3, Vec3, Vec3];
  private readonly corner: Vec3; // of the frame, relative to the origin

  constructor(private readonly structure: LatticeStructure, private readonly origin: Vec3, outside: PatchPlan['outside']) {
    this.spans = spansOf(structure);
    const [n0, n1, n2] = this.spans.map((spans) => spans.length) as [number, number, number];
    this.terms = AXES.map((axis) => structure.degree[axis] + 1) as [number, number, number];
    this.perBox = this.terms[0] * this.terms[1] * this.terms[2];
    this.steps = [1, n0, n0 * n1];
    this.boxCount = 1 + n0 * n1 * n2;
    this.numbers = new Float32Array(4 * this.perBox * this.boxCount);
    this.isStale = new Uint8Array(this.boxCount).fill(1, 1);
    this.restEdges = AXES.map((axis) => {
      const [begin, end] = domain(structure, axis);
      return scale(frameEdges(structure.frame)[axis], 1 / (end - begin));
    }) as [Vec3, Vec3, Vec3];
    this.corner = sub(structure.frame.origin, origin);
    if (outside) this.writeOutside(outside);
  }

  /** Whether derivatives do not jump at the lower end of a span above 0: fewer knots than the degree are there. */
  isSmoothBelow(axis: number, span: number): boolean {
    const spans = this.spans[axis]!;
    return spans[span]!.firstPoint - spans[span - 1]!.firstPoint < this.structure.degree[axis]!;
  }

  /** These control points have moved; absent: all. The boxes that they affect are computed by the next `update`. */
  moved(indices?: Iterable<number>): void {
    if (!indices) return void this.isStale.fill(1, 1);
    for (const index of indices) {
      const [a, b, c] = placeOf(this.structure.size, index).map((place, axis) => this.spansWith(axis, place)) as [number[], number[], number[]];
      for (const i of a) for (const j of b) for (const k of c) this.isStale[this.boxOf(i, j, k)] = 1;
    }
  }

  /** Computes the boxes that are affected, and returns their numbers, ascending. */
  update(points: Float64Array): number[] {
    const changed: number[] = [];
    const [n0, n1, n2] = this.spans.map((spans) => spans.length) as [number, number, number];
    for (let k = 0; k < n2; ++k) {
      for (let j = 0; j < n1; ++j) {
        for (let i = 0; i < n0; ++i) {
          const box = this.boxOf(i, j, k);
          if (!this.isStale[box]) continue;
          this.writeBox(box, [this.spans[0][i]!, this.spans[1][j]!, this.spans[2][k]!], points);
          this.isStale[box] = 0;
          changed.push(box);
        }
      }
    }
    return changed;
  }

  /** The position relative to the origin at local coordinates, as the shader evaluates it, but in double. */
  at(box: number, l: Vec3, out: Float64Array, to: number): void {
    const [t0, t1, t2] = this.terms;
    let at = 4 * this.perBox * (box + 1);
    let [x, y, z] = [0, 0, 0];
    for (let k = t2; k > 0; --k) {
      let [px, py, pz] = [0, 0, 0];
      for (let j = t1; j > 0; --j) {
        let [lx, ly, lz] = [0, 0, 0];
        for (let i = t0; i > 0; --i) {
          at -= 4;
          lx = lx * l[0] + this.numbers[at]!;
          ly = ly * l[0] + this.numbers[at + 1]!;
          lz = lz * l[0] + this.numbers[at + 2]!;
        }
        px = px * l[1] + lx;
        py = py * l[1] + ly;
        pz = pz * l[1] + lz;
      }
      x = x * l[2] + px;
      y = y * l[2] + py;
      z = z * l[2] + pz;
    }
    out[to] = x;
    out[to + 1] = y;
    out[to + 2] = z;
  }

  /** The point of a weighted plan: as `at` with the weight 1, and at rest with 0. */
  weightedAt(box: number, l: Vec3, weight: number, out: Float64Array, to: number): void {
    this.at(box, l, out, to);
    if (box === 0) return;
    const first = 4 * this.perBox * box;
    const middle = [first, first + 4 * (1 + this.terms[0]), first + 4 * (1 + this.terms[0] * this.terms[1])];
    for (const axis of AXES) {
      let rest = this.numbers[middle[axis]! + 3]!;
      for (const along of AXES) rest += l[along] * this.numbers[first + 4 * this.placeOf(along) + 3]! * this.restEdges[along][axis];
      out[to + axis] = rest + weight * (out[to + axis]! - rest);
    }
  }

  /** No point of a box is moved from its place at rest by more than this along x, y and z: no l is beyond 1/2. */
  largestMove(box: number): [number, number, number] {
    if (box === 0) return [0, 0, 0];
    const { terms: [t0, t1], numbers, perBox } = this;
    const first = 4 * perBox * box;
    const middle = [0, 1 + t0, 1 + t0 * t1];
    return AXES.map((axis) => {
      const moves = Float64Array.from({ length: perBox }, (_, n) => numbers[first + 4 * n + axis]!);
      moves[0]! -= numbers[first + 4 * middle[axis]! + 3]!;
      for (const along of AXES) moves[this.placeOf(along)]! -= numbers[first + 4 * this.placeOf(along) + 3]! * this.restEdges[along][axis];
      return moves.reduce((sum, move, n) => {
        const powers = (n % t0) + (Math.floor(n / t0) % t1) + Math.floor(n / (t0 * t1));
        return sum + Math.abs(move) * 0.5 ** powers;
      }, 0);
    }) as [number, number, number];
  }

  private boxOf(i: number, j: number, k: number): number {
    return 1 + i + this.steps[1] * j + this.steps[2] * k;
  }

  private spansWith(axis: number, place: number): number[] {
    const degree = this.structure.degree[axis]!;
    return this.spans[axis]!.flatMap(({ firstPoint }, span) => (firstPoint <= place && place <= firstPoint + degree ? [span] : []));
  }

  private writeOutside([lower, upper]: readonly [Vec3, Vec3]): void {
    for (const axis of AXES) {
      this.numbers[axis] = (lower[axis] + upper[axis]) / 2 - this.origin[axis];
      this.numbers[4 * this.placeOf(axis) + axis] = upper[axis] - lower[axis];
    }
  }

  /** The place of the factor of l_axis. */
  private placeOf(axis: number): number {
    return [1, this.terms[0], this.terms[0] * this.terms[1]][axis]!;
  }

  /** Contracts one axis after the other: control points to powers of l_0, l_1 and l_2. */
  private writeBox(box: number, spans: readonly [Span, Span, Span], points: Float64Array): void {
    const { size } = this.structure;
    const [t0, t1, t2] = this.terms;
    const [s0, s1, s2] = spans;
    const first = 4 * this.perBox * box;
    for (const axis of AXES) {
      // Relative to a control point of the box, so that derivatives are exactly 0 where all of them coincide.
      const base = points[3 * (s0.firstPoint + size[0] * (s1.firstPoint + size[1] * s2.firstPoint)) + axis]!;
      let values: number[] = [];
      for (let k = 0; k < t2; ++k) {
        for (let j = 0; j < t1; ++j) {
          const row = s0.firstPoint + size[0] * (s1.firstPoint + j + size[1] * (s2.firstPoint + k));
          for (let i = 0; i < t0; ++i) values.push(points[3 * (row + i) + axis]! - base);
        }
      }
      values = contracted(values, s0.factors, 1, t0);
      values = contracted(values, s1.factors, t0, t1);
      values = contracted(values, s2.factors, t0 * t1, t2);
      values[0]! += base - this.origin[axis];
      for (let n = 0; n < this.perBox; ++n) this.numbers[first + 4 * n + axis] = values[n]!;
    }
    for (const axis of AXES) this.numbers[first + 4 * this.placeOf(axis) + 3] = spans[axis].width;
    [0, 1 + t0, 1 + t0 * t1].forEach((place, axis) => {
      this.numbers[first + 4 * place + 3] = AXES.reduce((sum, along) => sum + spans[along].middle * this.restEdges[along][axis]!, this.corner[axis]!);
    });
  }
}

/** The sums over i of factors[p][i] times the value whose digit with this stride is i, in the place where it is p. */
function contracted(values: readonly number[], factors: Span['factors'], stride: number, terms: number): number[] {
  return values.map((_, n) => {
    const p = Math.floor(n / stride) % terms;
    const base = n - p * stride;
    let sum = 0;
    for (let i = 0; i < terms; ++i) sum += factors[p]![i]! * values[base + i * stride]!;
    return sum;
  });
}

/** From a sum of three weighted places to a local coordinate (patches.proto). */
export function localCoordinate(sum: number, denominator: number): number {
  return (2 * sum - KNOT * denominator) / (2 * KNOT * denominator);
}

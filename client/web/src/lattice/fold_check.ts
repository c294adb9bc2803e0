// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where a lattice folds over: where the determinant of its map from rest to deformed, 1 at rest, is not positive.
//
//   J(u,v,w) = det[dR/du dR/dv dR/dw] / the same at rest
//
// J is sampled on a grid in the knot boxes, axis by axis, so that the work grows with samples and not with their basis
// functions. A fold between samples is missed.
import { basisFunctions, findSpan } from './bspline';
import { AXES, domain, frameEdges, type Axes, type Axis, type LatticeStructure } from './grid';
import { cross, dot } from './vec';

const MOST_SAMPLES = 60_000; // with 32,768 control points they take about 0.1 s
const MOST_PER_BOX = 3; // along each axis
const NOTHING = 1e-9; // of the volume at rest

/** A box in fractions of the frame: 0 to 1 is the lattice's own extent along an axis. */
export type Fractions = readonly [axis: Range, axis: Range, axis: Range];
type Range = readonly [begin: number, end: number];

/** One sampled parameter along an axis: its basis functions and their derivatives. */
interface Sample {
  /** The first control point that they belong to. */
  readonly first: number;
  readonly basis: readonly number[];
  readonly slope: readonly number[];
}

export class FoldCheck {
  private readonly samples: readonly [Sample[], Sample[], Sample[]];
  private readonly atRest: number;

  /** @param within The part of the lattice that matters, where the mesh is. */
  constructor(private readonly structure: LatticeStructure, within: Fractions) {
    const boxes = AXES.map((axis) => intervals(structure, axis, within[axis]));
    const count = boxes.reduce((product, { length }) => product * length, 1);
    const perBox = Math.min(Math.max(Math.floor(Math.cbrt(MOST_SAMPLES / Math.max(count, 1))), 1), MOST_PER_BOX);
    const along = (axis: Axis): Sample[] =>
      boxes[axis].flatMap((box) => spread(box, perBox)).map((t) => sampleAt(structure, axis, t));
    this.samples = [along(0), along(1), along(2)];
    const [u, v, w] = frameEdges(structure.frame);
    this.atRest = AXES.reduce((volume, axis) => {
      const [begin, end] = domain(structure, axis);
      return volume / (end - begin);
    }, dot(u, cross(v, w)));
  }

  /** The control points whose influence covers the place that is folded over most; undefined if nothing is. */
  folded(points: Float64Array): number[] | undefined {
    const { size, degree } = this.structure;
    const [us, vs, ws] = this.samples;
    const inU = contracted(points, 3, size[0], us);
    const inV = contracted(inU.value, 3 * us.length, size[1], vs);
    const slopesU = contracted(inU.slope, 3 * us.length, size[1], vs).value;
    const plane = 3 * us.length * vs.length;
    let [least, worst]: [number, Axes | undefined] = [NOTHING, undefined];
    ws.forEach(({ first, basis, slope }, c) => {
      const du = layer(slopesU, plane, first, basis);
      const dv = layer(inV.slope, plane, first, basis);
      const dw = layer(inV.value, plane, first, slope);
      for (let at = 0; at < plane; at += 3) {
        const j = determinant(du, dv, dw, at) / this.atRest;
        if (j > least) continue;
        const i = at / 3;
        [least, worst] = [j, [i % us.length, Math.floor(i / us.length), c]];
      }
    });
    return worst && covering(size, degree, [us[worst[0]].first, vs[worst[1]].first, ws[worst[2]].first]);
  }
}

/** The parts of an axis's knot intervals in a range of fractions. */
function intervals(structure: LatticeStructure, axis: Axis, [from, to]: Range): Range[] {
  const { knots, degree, size } = structure;
  const [begin, end] = domain(structure, axis);
  const [low, high] = [begin + from * (end - begin), begin + to * (end - begin)];
  const found: Range[] = [];
  for (let i = degree[axis]; i < size[axis]; ++i) {
    const part: Range = [Math.max(knots[axis][i], low), Math.min(knots[axis][i + 1], high)];
    if (knots[axis][i] < knots[axis][i + 1] && part[0] <= part[1]) found.push(part);
  }
  return found;
}

/** Parameters in the middle of `count` equal parts. */
function spread([begin, end]: Range, count: number): number[] {
  return Array.from({ length: count }, (_, i) => begin + ((i + 0.5) / count) * (end - begin));
}

function sampleAt({ knots, degree, size }: LatticeStructure, axis: Axis, t: number): Sample {
  const [all, p] = [knots[axis], degree[axis]];
  const span = findSpan(all, p, size[axis], t);
  const slope: number[] = Array(p + 1).fill(0);
  basisFunctions(all, p - 1, span, t).forEach((lower, r) => {
    const part = (p * lower) / (all[span + r + 1] - all[span - p + r + 1]);
    slope[r + 1] += part;
    slope[r] -= part;
  });
  return { first: span - p, basis: basisFunctions(all, p, span, t), slope };
}

/** Replaces an axis, of `size` entries of `width` numbers, by its samples: the values and the derivatives there. */
function contracted(data: Float64Array, width: number, size: number, samples: readonly Sample[]) {
  const rows = data.length / (width * size);
  const value = new Float64Array(rows * samples.length * width);
  const slope = new Float64Array(value.length);
  let to = 0;
  for (let row = 0; row < rows; ++row) {
    for (const sample of samples) {
      for (let n = 0; n < width; ++n, ++to) {
        let from = width * (row * size + sample.first) + n;
        for (let i = 0; i < sample.basis.length; ++i, from += width) {
          value[to] += sample.basis[i] * data[from];
          slope[to] += sample.slope[i] * data[from];
        }
      }
    }
  }
  return { value, slope };
}

/** The sum of planes of numbers, with weights. */
function layer(data: Float64Array, plane: number, first: number, weights: readonly number[]): Float64Array {
  const sum = new Float64Array(plane);
  weights.forEach((weight, c) => {
    const from = (first + c) * plane;
    for (let i = 0; i < plane; ++i) sum[i] += weight * data[from + i];
  });
  return sum;
}

function determinant(a: Float64Array, b: Float64Array, c: Float64Array, i: number): number {
  const [j, k] = [i + 1, i + 2];
  return a[i] * (b[j] * c[k] - b[k] * c[j]) + a[j] * (b[k] * c[i] - b[i] * c[k]) + a[k] * (b[i] * c[j] - b[j] * c[i]);
}

function covering(size: Axes, degree: Axes, [u, v, w]: Axes): number[] {
  const found: number[] = [];
  for (let k = w; k <= w + degree[2]; ++k) {
    for (let j = v; j <= v + degree[1]; ++j) {
      for (let i = u; i <= u + degree[0]; ++i) found.push(i + size[0] * (j + size[1] * k));
    }
  }
  return found;
}

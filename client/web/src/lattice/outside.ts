// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a lattice goes on outside its frame: the larger lattice that the server's plans are of. Its displacements are
// the strength times E_w x E_v x E_u times the given ones (core/ffd/outside/outside_map.h has the formulas).
import { AXES, domain, frameEdges, type Axis, type LatticeStructure } from './grid';
import { identityPoints } from './identity';
import { Lattice, type Outside } from './lattice';
import { add, scale, type Vec3 } from './vec';

const LEAST_WIDTH = 0.001; // the server's; less is 0
export const MOST_WIDTH = 1000;

/** The width nearest to one that is wanted: 0, or what the server takes. */
export function allowedWidth(width: number): number {
  return width < LEAST_WIDTH ? 0 : Math.min(width, MOST_WIDTH);
}

/** A row of E on one axis: control points of the given lattice from `first` on, and their weights. */
interface Row {
  readonly first: number;
  readonly weights: readonly number[];
}

interface Side {
  /** Distances from the face, outwards. */
  readonly knots: number[];
  /** From the outermost. */
  readonly rows: (readonly number[])[];
  /** How many control points they take the place of. */
  readonly replaced: number;
}

export class OutsideMap {
  readonly continued: LatticeStructure;
  private readonly rows: readonly Row[][];
  private readonly rest: Float64Array;
  private readonly continuedRest: Float64Array;
  private readonly isIdentity: boolean;

  constructor(private readonly structure: LatticeStructure) {
    const { outside } = structure;
    this.isIdentity = !outside || outside.widths.every((width) => width === 0);
    const axes = AXES.map((axis) => (this.isIdentity ? undefined : continueAxis(structure, outside!, axis)));
    this.rows = axes.map((axis) => axis?.rows ?? []);
    this.continued = structure;
    if (!this.isIdentity) {
      let { origin } = structure.frame;
      const edges = frameEdges(structure.frame).map((edge, axis) => {
        const [before, after] = outside!.widths.slice(2 * axis, 2 * axis + 2) as [number, number];
        origin = add(origin, scale(edge, -before));
        return scale(edge, 1 + before + after);
      }) as [Vec3, Vec3, Vec3];
      this.continued = {
        frame: { origin, u: edges[0], v: edges[1], w: edges[2] },
        degree: structure.degree,
        size: this.rows.map((rows) => rows.length) as unknown as Vec3,
        knots: axes.map((axis) => axis!.knots) as unknown as LatticeStructure['knots'],
      };
    }
    this.rest = identityPoints(structure);
    this.continuedRest = this.isIdentity ? this.rest : identityPoints(this.continued);
  }

  /** The control points of the continued lattice; those of the given one itself, if nothing goes on and the strength is 1. */
  points(given: Float64Array, strength = 1): Float64Array {
    if (this.isIdentity && strength === 1) return given;
    const { rest } = this;
    const points = this.continuedRest.slice();
    const add = (index: number, source: number, weight: number): void => {
      for (const axis of AXES) {
        const from = 3 * source + axis;
        // Without this, -0 + 0 would change a bit of a point at rest.
        if (given[from] !== rest[from]) points[3 * index + axis]! += strength * weight * (given[from]! - rest[from]!);
      }
    };
    if (this.isIdentity) for (let i = 0; 3 * i < given.length; ++i) add(i, i, 1);
    else this.forSources(add);
    return points;
  }

  /** The control points of the continued lattice that depend on these. */
  reached(indices: Iterable<number>): Iterable<number> {
    if (this.isIdentity) return indices;
    const moved = new Set(indices), reached = new Set<number>();
    this.forSources((index, source) => {
      if (moved.has(source)) reached.add(index);
    });
    return reached;
  }

  /** The control points of the given lattice on which these of the continued one depend, ascending. */
  sources(indices: Iterable<number>): number[] {
    if (this.isIdentity) return [...indices];
    const wanted = new Set(indices), sources = new Set<number>();
    this.forSources((index, source) => {
      if (wanted.has(index)) sources.add(source);
    });
    return [...sources].sort((a, b) => a - b);
  }

  private forSources(visit: (index: number, source: number, weight: number) => void): void {
    const [us, vs, ws] = this.rows as [Row[], Row[], Row[]];
    const { size } = this.structure;
    let index = -1;
    for (const w of ws) {
      for (const v of vs) {
        for (const u of us) {
          ++index;
          w.weights.forEach((c, k) => v.weights.forEach((b, j) => u.weights.forEach((a, i) => {
            visit(index, u.first + i + size[0] * (v.first + j + size[1] * (w.first + k)), a * b * c);
          })));
        }
      }
    }
  }
}

/** The continued lattice of a lattice, of strength 1; or the lattice itself if nothing goes on and that is its strength. */
export function continuedLattice(lattice: Lattice): Lattice {
  if (!lattice.outside && lattice.strength === 1) return lattice;
  const map = new OutsideMap(lattice);
  const { frame, degree, size, knots } = map.continued;
  return new Lattice(frame, degree, size, knots, map.points(lattice.points, lattice.strength));
}

/** The lattice of strength 1 that deforms as this one. */
export function effectiveLattice(lattice: Lattice): Lattice {
  if (lattice.strength === 1) return lattice;
  const { frame, degree, size, knots, points, outside, strength } = lattice;
  const rest = identityPoints(lattice);
  return new Lattice(frame, degree, size, knots, points.map((x, i) => rest[i]! + strength * (x - rest[i]!)), outside);
}

function continueAxis(structure: LatticeStructure, outside: Outside, axis: Axis): { knots: Float64Array; rows: Row[] } {
  const knots = structure.knots[axis], degree = structure.degree[axis], size = structure.size[axis];
  const [begin, end] = domain(structure, axis);
  const range = end - begin;
  const front = continueSide(outside, 2 * axis, degree, range, knots[degree + 1]! - begin);
  const back = continueSide(outside, 2 * axis + 1, degree, range, end - knots[size - 1]!);
  const inner = Array.from({ length: size - front.replaced - back.replaced }, (_, i) => ({ first: front.replaced + i, weights: [1] }));
  const rows: Row[] = [
    ...front.rows.map((weights) => ({ first: 0, weights })),
    ...inner,
    ...back.rows.map((weights) => ({ first: size - weights.length, weights: [...weights].reverse() })).reverse(),
  ];
  return {
    rows,
    knots: Float64Array.from([
      ...front.knots.map((knot) => begin - knot).reverse(),
      ...knots.subarray(degree + 1, size),
      ...back.knots.map((knot) => end + knot),
    ]),
  };
}

/** `span`: the first knot span inside. */
function continueSide(outside: Outside, side: number, degree: number, range: number, span: number): Side {
  const width = outside.widths[side]! * range;
  const repeated = (distance: number, times: number): number[] => new Array<number>(times).fill(distance);
  if (width === 0) return { knots: repeated(0, degree + 1), rows: [], replaced: 0 };
  if (outside.mode === 'linear') {
    const rows = Array.from({ length: degree }, (_, i) => ((degree - i) * width) / span);
    return { knots: [...repeated(0, degree), ...repeated(width, degree + 1)], rows: rows.map((r) => [1 + r, -r]), replaced: 0 };
  }
  const isSmooth = outside.smooth && degree > 1;
  const step = outside.steps.length > 0 ? outside.steps[side]! * range : Math.min(width / 2, span / 4);
  const distance = step / (degree * width);
  const last = isSmooth ? [1 + step / span, -step / span] : [1 - distance * distance * (3 - 2 * distance)];
  return {
    knots: [...repeated(0, isSmooth ? degree - 1 : degree), step, ...repeated(width, degree + 1)],
    rows: [...Array.from({ length: degree }, () => []), last],
    replaced: isSmooth ? 1 : 0,
  };
}

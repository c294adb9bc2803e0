// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { AXES } from '../lattice/grid';
import type { Vec3 } from '../lattice/vec';
import type { TopologyLayout } from '../surface/topology_layout';
import { boundSecondDerivatives, PAIRS } from './box_bends';
import { localCoordinate, type BoxPolynomials } from './box_polynomials';
import type { CornerPositions } from './corner_positions';
import { KNOT, spanOf, type PatchPlan } from './plan/patch_plan';

/** The patches of a chunk that lie in one box. */
interface Part {
  readonly box: number;
  /** By pairs of axes, the most of |d_a d_b| of a patch's edge d, in local coordinates; twice that for two different axes. */
  readonly products: Float64Array;
}

/** Points of all patches at which extents are computed, about. They take 2 ms with degree 2. */
const SAMPLES = 8000;

/**
 * Boxes around the surface of each chunk, which hold all points of its patches and not only their corners. Each edge is divided
 * into a few parts. A point is no farther from the flat triangle of its part than 1/6 of the largest second derivative along the
 * edges, on each coordinate. These follow from the polynomials of the boxes, so the page need not know the server's bounds, which
 * are those of an older lattice while edits come. With weights they hold the surface of weight 1 and that at rest, between which
 * all points lie. Points on an attached seam may be outside by the rounding of places.
 */
export class ChunkExtents {
  /** Of each edge. */
  private readonly divisions: number;
  private readonly parts: readonly (readonly Part[])[];
  /** Of the patches outside the frame, which stay where they are. */
  private readonly outside: readonly Float32Array[];
  /** 18 numbers for each box of the lattice: boundSecondDerivatives. */
  private readonly bends: Float64Array;

  constructor(
    private readonly plan: PatchPlan, private readonly layout: TopologyLayout, private readonly boxes: BoxPolynomials,
    private readonly corners: CornerPositions, private readonly boxOfPatch: (patch: number) => number,
  ) {
    this.divisions = Math.max(1, Math.floor(Math.sqrt((2 * SAMPLES) / Math.max(plan.insideCount, 1))) - 1);
    this.bends = new Float64Array(18 * boxes.boxCount);
    const outsidePositions = outsideCorners(plan);
    this.outside = Array.from({ length: layout.chunkCount }, (_, chunk) => {
      const extent = emptyExtent();
      const [first, end] = [layout.firstPatch[chunk]!, layout.firstPatch[chunk + 1]!];
      for (let at = 3 * Math.max(first, plan.insideCount); at < 3 * end; ++at) include(extent, outsidePositions, 3 * plan.corners[at]!);
      return extent;
    });
    this.parts = Array.from({ length: layout.chunkCount }, (_, chunk) => {
      const parts = new Map<number, Float64Array>();
      for (const patch of this.patchesInside(chunk)) {
        const box = boxOfPatch(patch);
        const products = parts.get(box) ?? new Float64Array(PAIRS.length);
        parts.set(box, products);
        this.addEdges(patch, products);
      }
      return Array.from(parts, ([box, products]) => ({ box, products }));
    });
  }

  /** The polynomials of these boxes are others now. */
  update(boxes: readonly number[]): void {
    const { numbers, perBox, terms } = this.boxes;
    for (const box of boxes) boundSecondDerivatives(numbers, 4 * perBox * box, terms, this.bends.subarray(18 * box, 18 * box + 18));
  }

  /** min x y z, max x y z of a chunk, relative to the plan's origin. */
  of(chunk: number): Float32Array {
    const { divisions, plan, corners } = this;
    const extent = emptyExtent();
    for (const patch of this.patchesInside(chunk)) {
      if (divisions > 1 || plan.weights) this.includeSamples(extent, patch);
      else for (let at = 3 * patch; at < 3 * patch + 3; ++at) include(extent, corners.positions, 3 * plan.corners[at]!);
    }
    const outside = this.outside[chunk]!;
    for (const axis of AXES) {
      const bulge = this.bulge(chunk, axis);
      extent[axis] = Math.min(outside[axis]!, extent[axis]! - bulge);
      extent[axis + 3] = Math.max(outside[axis + 3]!, extent[axis + 3]! + bulge);
    }
    return extent;
  }

  private *patchesInside(chunk: number): Generator<number> {
    const end = Math.min(this.layout.firstPatch[chunk + 1]!, this.plan.insideCount);
    for (let patch = this.layout.firstPatch[chunk]!; patch < end; ++patch) yield patch;
  }

  /** How far points of a chunk may be from flat triangles between samples, on a coordinate. */
  private bulge(chunk: number, axis: number): number {
    let most = 0;
    for (const { box, products } of this.parts[chunk]!) {
      let bend = 0;
      for (let pair = 0; pair < PAIRS.length; ++pair) bend += products[pair]! * this.bends[18 * box + 6 * axis + pair]!;
      most = Math.max(most, bend);
    }
    return most / (6 * this.divisions ** 2);
  }

  private includeSamples(extent: Float32Array, patch: number): void {
    const { divisions, boxes } = this;
    const { corners, places } = this.plan;
    const [p, q, r] = [0, 1, 2].map((k) => 3 * corners[3 * patch + k]!) as [number, number, number];
    const box = this.boxOfPatch(patch);
    const spans = AXES.map((axis) => spanOf(places[p + axis]!, places[q + axis]!, places[r + axis]!));
    const position = new Float64Array(3);
    for (let i = 0; i <= divisions; ++i) {
      for (let j = 0; i + j <= divisions; ++j) {
        const l = AXES.map((axis) => {
          const sum = (divisions - i - j) * places[p + axis]! + i * places[q + axis]! + j * places[r + axis]!;
          return localCoordinate(sum - divisions * KNOT * spans[axis]!, divisions);
        });
        boxes.at(box, l as unknown as Vec3, position, 0);
        include(extent, position, 0);
        if (!this.plan.weights) continue;
        boxes.weightedAt(box, l as unknown as Vec3, 0, position, 0);
        include(extent, position, 0);
      }
    }
  }

  private addEdges(patch: number, products: Float64Array): void {
    const { corners, places } = this.plan;
    for (let e = 0; e < 3; ++e) {
      const [p, q] = [3 * corners[3 * patch + e]!, 3 * corners[3 * patch + ((e + 1) % 3)]!];
      PAIRS.forEach(([a, b], pair) => {
        const product = ((places[q + a]! - places[p + a]!) * (places[q + b]! - places[p + b]!)) / KNOT ** 2;
        products[pair] = Math.max(products[pair]!, Math.abs(product) * (a === b ? 1 : 2));
      });
    }
  }
}

function emptyExtent(): Float32Array {
  return Float32Array.of(Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity);
}

/** Grows min x y z, max x y z by the position at a place of an array. */
function include(extent: Float32Array, positions: Float64Array, at: number): void {
  for (let axis = 0; axis < 3; ++axis) {
    const x = positions[at + axis]!;
    if (x < extent[axis]!) extent[axis] = x;
    if (x > extent[axis + 3]!) extent[axis + 3] = x;
  }
}

/** Where patches outside the frame have vertices, relative to the plan's origin: on a torn seam not where patches inside have them. */
function outsideCorners({ places, seams, vertexCount, outside, origin }: PatchPlan): Float64Array {
  const positions = new Float64Array(3 * vertexCount);
  if (!outside) return positions;
  const [lower, upper] = outside;
  const place = (vertex: number, from: Int32Array, at: number): void => {
    for (const axis of AXES) {
      positions[3 * vertex + axis] = lower[axis] - origin[axis] + ((upper[axis] - lower[axis]) * from[at + axis]!) / KNOT;
    }
  };
  for (let vertex = 0; vertex < vertexCount; ++vertex) place(vertex, places, 3 * vertex);
  seams.vertices.forEach((vertex, i) => place(vertex, seams.outsidePlaces, 3 * i));
  return positions;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from '../lattice/vec';
import type { TopologyLayout } from '../surface/topology_layout';
import { localCoordinate, type BoxPolynomials } from './box_polynomials';
import { KNOT, spanOf, WEIGHT_ONE, type PatchPlan } from './plan/patch_plan';

/**
 * Where the vertices of a plan are, on the CPU: from them follow which patches are near, and the boxes around chunks. Also says
 * which vertices and chunks a box of the lattice holds.
 */
export class CornerPositions {
  /** x y z of each vertex, relative to the plan's origin. */
  readonly positions: Float64Array;
  private readonly boxOfVertex: Uint32Array;
  private readonly locals: Float64Array;
  private readonly boxesOfChunk: readonly (readonly number[])[];

  constructor(private readonly plan: PatchPlan, layout: TopologyLayout, private readonly boxes: BoxPolynomials, boxOfPatch: (patch: number) => number) {
    const { vertexCount, insideCount, corners, places } = plan;
    this.positions = new Float64Array(3 * vertexCount);
    this.locals = new Float64Array(3 * vertexCount);
    this.boxOfVertex = new Uint32Array(vertexCount);
    const isInside = new Uint8Array(vertexCount);
    for (let at = 0; at < 3 * insideCount; ++at) isInside[corners[at]!] = 1;
    for (let vertex = 0; vertex < vertexCount; ++vertex) {
      let box = isInside[vertex]!;
      for (let axis = 0; axis < 3; ++axis) {
        const place = places[3 * vertex + axis]!;
        const span = isInside[vertex] ? Math.max(0, Math.ceil(place / KNOT) - 1) : 0;
        box += span * boxes.steps[axis]!;
        this.locals[3 * vertex + axis] = localCoordinate(place - KNOT * span, 1);
      }
      this.boxOfVertex[vertex] = box;
    }
    this.boxesOfChunk = Array.from({ length: layout.chunkCount }, (_, chunk) => {
      const own = new Set<number>();
      for (let patch = layout.firstPatch[chunk]!; patch < layout.firstPatch[chunk + 1]!; ++patch) {
        for (const box of this.boxesWith(patch, boxOfPatch(patch))) own.add(box);
      }
      return [...own];
    });
  }

  /** A patch's own box, and the lower ones in which its points on knot planes are evaluated. */
  private boxesWith(patch: number, own: number): number[] {
    let boxes = [own];
    if (own === 0) return boxes;
    const { corners, places } = this.plan;
    for (let axis = 0; axis < 3; ++axis) {
      const [a, b, c] = [0, 1, 2].map((k) => places[3 * corners[3 * patch + k]! + axis]!) as [number, number, number];
      const span = spanOf(a, b, c);
      if (span > 0 && Math.min(a, b, c) === KNOT * span) boxes = boxes.flatMap((box) => [box, box - this.boxes.steps[axis]!]);
    }
    return boxes;
  }

  /** No point of the patches is moved from its place at rest by more than this along x, y and z, where it follows the lattice. */
  largestMove(): Vec3 {
    const moves = Array.from(new Set(this.boxesOfChunk.flat()), (box) => this.boxes.largestMove(box));
    return moves.reduce(([x, y, z], move) => [Math.max(x, move[0]), Math.max(y, move[1]), Math.max(z, move[2])], [0, 0, 0]);
  }

  /** Moves the vertices of these boxes; absent: of all. Returns the chunks whose points have moved with them. */
  update(boxes?: readonly number[]): number[] {
    const { weights } = this.plan;
    const isChanged = new Uint8Array(this.boxes.boxCount).fill(boxes ? 0 : 1);
    for (const box of boxes ?? []) isChanged[box] = 1;
    for (let vertex = 0; vertex < this.boxOfVertex.length; ++vertex) {
      const box = this.boxOfVertex[vertex]!;
      if (!isChanged[box]) continue;
      const l = this.locals.subarray(3 * vertex, 3 * vertex + 3) as never;
      if (weights) this.boxes.weightedAt(box, l, weights[vertex]! / WEIGHT_ONE, this.positions, 3 * vertex);
      else this.boxes.at(box, l, this.positions, 3 * vertex);
    }
    return Array.from(this.boxesOfChunk.keys()).filter((chunk) => this.boxesOfChunk[chunk]!.some((box) => isChanged[box]));
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from '../../lattice/vec';
import { KNOT, spanOf, type PatchPlan } from '../plan/patch_plan';

const CORNER_ATTACHED = 1;
const EDGE_ATTACHED = 2;

/** What the shader must know of patches, as its header lays it out (evaluate_patch.vert). */
export class PatchTables {
  /** Four integers in each of four texels a patch. */
  readonly patches: Int32Array;
  /** Four integers in each of three texels a record. */
  readonly seams: Int32Array;
  private readonly patchOfRecord: Uint32Array;
  private readonly seamOfVertex: Map<number, number>;
  private readonly seamOfEdge: Map<number, number>;

  /**
   * @param steps BoxPolynomials.steps.
   * @param isSmoothBelow Whether derivatives do not jump at the lower end of a span of an axis.
   */
  constructor(private readonly plan: PatchPlan, steps: Vec3, isSmoothBelow: (axis: number, span: number) => boolean) {
    const { vertices, vertexSeams, edges, edgeSeams } = plan.seams;
    this.seamOfVertex = new Map(Array.from(vertices, (vertex, i) => [vertex, vertexSeams[i]!]));
    this.seamOfEdge = new Map(Array.from(edges, (edge, i) => [edge, edgeSeams[i]!]));
    const outsideAt = new Map(Array.from(vertices, (vertex, i) => [vertex, 3 * i]));
    this.patches = new Int32Array(16 * plan.patchCount);
    const records: number[] = [];
    for (let patch = 0; patch < plan.patchCount; ++patch) {
      const isInside = patch < plan.insideCount;
      const [a, b, c] = plan.corners.subarray(3 * patch, 3 * patch + 3) as unknown as Vec3;
      const places = (vertex: number): ArrayLike<number> => {
        const outside = isInside ? undefined : outsideAt.get(vertex);
        return outside === undefined ? plan.places.subarray(3 * vertex, 3 * vertex + 3) : plan.seams.outsidePlaces.subarray(outside, outside + 3);
      };
      const corners = [a, b, c].map(places);
      const spans = [0, 1, 2].map((axis) => (isInside ? spanOf(corners[0]![axis]!, corners[1]![axis]!, corners[2]![axis]!) : 0));
      corners.forEach((corner, k) => {
        const at = 16 * patch + 4 * k;
        for (let axis = 0; axis < 3; ++axis) this.patches[at + axis] = corner[axis]! - KNOT * spans[axis]!;
        this.patches[at]! |= (plan.weights?.[plan.corners[3 * patch + k]!] ?? 0) << 16;
        this.patches[at + 3] = plan.cornerNormals[3 * patch + k]!;
      });
      const facts = 16 * patch + 12;
      this.patches[facts] = isInside ? 1 + spans[0]! * steps[0] + spans[1]! * steps[1] + spans[2]! * steps[2] : 0;
      this.patches[facts + 1] = spans.reduce((bits, span, axis) =>
        bits | (span > 0 ? (isSmoothBelow(axis, span) ? 9 : 1) << axis : 0), 0);
      if (isInside && this.isOnSeam(patch)) this.patches[facts + 2] = records.push(patch);
    }
    this.patchOfRecord = Uint32Array.from(records);
    this.seams = new Int32Array(12 * records.length);
    this.patchOfRecord.forEach((patch, record) => {
      for (let k = 0; k < 3; ++k) {
        const from = outsideAt.get(plan.corners[3 * patch + k]!);
        if (from !== undefined) this.seams.set(plan.seams.outsidePlaces.subarray(from, from + 3), 12 * record + 4 * k);
      }
    });
  }

  /** The box of a patch's own spans. */
  boxOf(patch: number): number {
    return this.patches[16 * patch + 12]!;
  }

  /** Writes which seams are attached into `seams`. */
  attach(isAttached: Uint8Array): void {
    const { corners, edges } = this.plan;
    const holds = (seam: number | undefined): boolean => seam !== undefined && isAttached[seam] === 1;
    this.patchOfRecord.forEach((patch, record) => {
      for (let k = 0; k < 3; ++k) {
        const corner = holds(this.seamOfVertex.get(corners[3 * patch + k]!)) ? CORNER_ATTACHED : 0;
        const edge = holds(this.seamOfEdge.get(edges[3 * patch + k]!)) ? EDGE_ATTACHED : 0;
        this.seams[12 * record + 4 * k + 3] = corner | edge;
      }
    });
  }

  private isOnSeam(patch: number): boolean {
    const { corners, edges } = this.plan;
    if (this.seamOfVertex.size === 0) return false;
    for (let at = 3 * patch; at < 3 * patch + 3; ++at) {
      if (this.seamOfVertex.has(corners[at]!) || this.seamOfEdge.has(edges[at]!)) return true;
    }
    return false;
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads the messages of GetPatchPlan: patches.proto. Without normals, and for meshes inside the lattice's frame.
import { inflateSync } from 'node:zlib';
import type { PatchPlanHeader__Output } from './generated/latticed/v1/PatchPlanHeader.js';
import type { PatchPlanPart__Output } from './generated/latticed/v1/PatchPlanPart.js';
import type { PatchRun__Output } from './generated/latticed/v1/PatchRun.js';
import { MOST_LEVEL } from './split_patch.js';

const UNKNOWN_BOUND = 255;

// Arrays of unsigned integers: the lowest bytes of all numbers come first, then the next bytes of all.
class BytePlanes {
  private read = 0;
  constructor(private readonly data: Buffer) {}

  take(count: number, width: number): number[] {
    const begin = this.read;
    this.read += count * width;
    if (this.read > this.data.length) throw new Error('a run of patches is too short');
    return Array.from({ length: count }, (_, i) => {
      let number = 0;
      for (let byte = width - 1; byte >= 0; --byte) number = number * 256 + this.data[begin + byte * count + i]!;
      return number;
    });
  }

  get left(): number {
    return this.data.length - this.read;
  }
}

export class PatchPlan {
  /** Three vertices of each patch. */
  readonly corners: number[] = [];
  /** Where each vertex lies on the three axes of the lattice: 65535 to a span. */
  readonly places: number[][] = [];
  /** Three edges of each patch, numbered by first use. Edge e joins corners e and (e + 1) modulo 3. */
  readonly edges: number[] = [];
  private edgeNumbers = new Map<string, number>();

  private constructor(private readonly header: PatchPlanHeader__Output) {
    if (header.patchesOutside) throw new Error('this example has no patches outside the frame');
    if (header.weighted) throw new Error('this example has no vertex weights');
  }

  /** Throws if the parts contradict each other. */
  static async read(parts: AsyncIterable<PatchPlanPart__Output>): Promise<PatchPlan> {
    let plan: PatchPlan | undefined;
    for await (const { header, run } of parts) {
      if (header) plan = new PatchPlan(header);
      if (run) plan?.takeRun(run);
    }
    if (plan?.patches !== plan?.header.patchCount || plan?.edgeCount !== plan?.header.edgeCount) {
      throw new Error('the patch plan is not whole');
    }
    return plan!;
  }

  get patches(): number {
    return this.corners.length / 3;
  }

  get edgeCount(): number {
    return this.edgeNumbers.size;
  }

  /** The least level of an edge that keeps the tolerance: E <= 6 tolerance 4^level. The edge has 2^level segments. */
  levelOf(edgeByte: number, tolerance: number): number {
    const bound = edgeByte === UNKNOWN_BOUND ? Infinity : this.header.curvatureUnit * 2 ** (edgeByte / 2);
    let level = 0;
    while (level < MOST_LEVEL && bound > 6 * tolerance * 4 ** level) ++level;
    return level;
  }

  private takeRun(run: PatchRun__Output): void {
    if (run.firstPatch !== this.patches) throw new Error('a run of patches is missing');
    const arrays = new BytePlanes(inflateSync(run.data));
    let known = this.places.length;
    for (const code of arrays.take(3 * run.patches, 4)) this.corners.push(code === 0 ? known++ : known - code);
    const differences = arrays.take(3 * run.newVertices, 4);
    if (known !== this.places.length + run.newVertices || arrays.left) throw new Error('a run of patches is damaged');
    const axes = [0, 1, 2].map((axis) => {
      let place = 0;
      return differences.slice(axis * run.newVertices, (axis + 1) * run.newVertices)
        .map((d) => place += d % 2 === 0 ? d / 2 : -(d + 1) / 2);
    });
    for (let i = 0; i < run.newVertices; ++i) this.places.push(axes.map((axis) => axis[i]!));
    for (let patch = run.firstPatch; patch < this.patches; ++patch) this.numberEdges(patch);
  }

  private numberEdges(patch: number): void {
    for (let e = 0; e < 3; ++e) {
      const ends = [this.corners[3 * patch + e]!, this.corners[3 * patch + (e + 1) % 3]!];
      const name = `${Math.min(...ends)} ${Math.max(...ends)}`;
      const number = this.edgeNumbers.get(name) ?? this.edgeNumbers.size;
      this.edgeNumbers.set(name, number);
      this.edges.push(number);
    }
  }
}

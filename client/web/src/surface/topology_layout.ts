// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Topology } from 'latticed/v1/event_pb';
import { ADAPTIVE_WHOLE, adaptivePattern } from './patches/adaptive_pattern';
import { pointsIn, type PatchPattern } from './patches/patch_pattern';
import { uniformPattern } from './patches/uniform_pattern';

/** The codes of a chunk's patches (Chunk.levels), one each; none in a view without a tolerance. */
export type PatternCodes = Uint16Array;

/** The patches of each chunk, and the points and triangles that a patch can have (event.proto, Topology). */
export class TopologyLayout {
  readonly id: string;
  /** Subdivisions per patch edge; 0 with a tolerance: patches have patterns of their own. */
  readonly segments: number;
  readonly patchCount: number;
  /** The sum of the barycentrics of a pattern's point: the segments, or with a tolerance the same for all patterns. */
  readonly whole: number;
  /** First patch of each chunk, and one past the last patch. */
  readonly firstPatch: Uint32Array;
  private readonly uniform: PatchPattern | undefined;

  constructor(message: Topology) {
    this.id = message.topologyId;
    this.segments = message.segments;
    this.patchCount = Number(message.patchCount);
    this.uniform = message.pattern && uniformPattern(message.pattern, message.segments);
    this.whole = this.uniform ? message.segments : ADAPTIVE_WHOLE;
    const first = [0];
    for (const run of message.chunkRuns) {
      for (let i = 0; i < run.chunkCount; ++i) first.push(first.at(-1)! + run.patchesPerChunk);
    }
    this.firstPatch = Uint32Array.from(first);
  }

  /** Whether each patch has a pattern of its own, which changes with updates. */
  get isAdaptive(): boolean {
    return this.uniform === undefined;
  }

  get chunkCount(): number {
    return this.firstPatch.length - 1;
  }

  /** Throws if there is no such chunk. */
  patchesOf(chunk: number): number {
    const count = this.firstPatch[chunk + 1]! - this.firstPatch[chunk]!;
    if (Number.isNaN(count)) throw new Error(`chunk ${chunk} of ${this.chunkCount}`);
    return count;
  }

  /** The pattern with a code; without a tolerance that of all patches. Throws if there is no such code. */
  patternOf(code: number): PatchPattern {
    return this.uniform ?? adaptivePattern(code);
  }

  /** The points of a chunk whose patches have these codes. Throws if codes lack or are too many. */
  pointsOf(chunk: number, codes: PatternCodes): number {
    const patches = this.patchesOf(chunk);
    if (this.uniform) return patches * pointsIn(this.uniform);
    if (codes.length !== patches) throw new Error(`${codes.length} patterns for ${patches} patches`);
    let points = 0;
    for (const code of codes) points += pointsIn(adaptivePattern(code));
    return points;
  }
}

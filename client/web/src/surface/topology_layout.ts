// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Topology } from 'latticed/v1/event_pb';

/** The place of each chunk's points, and their triangles (event.proto, Topology). */
export class TopologyLayout {
  readonly id: string;
  /** Subdivisions per patch edge. */
  readonly segments: number;
  readonly patchCount: number;
  readonly pointCount: number;
  readonly pointsPerPatch: number;
  /** (i0, i1, i2) of each point of a patch. */
  readonly patternPoints: Uint32Array;
  /** Point numbers inside the patch, three per triangle. */
  readonly patternTriangles: Uint32Array;
  /** First patch of each chunk, and one past the last patch. */
  readonly firstPatch: Uint32Array;

  constructor(message: Topology) {
    this.id = message.topologyId;
    this.segments = message.segments;
    this.patchCount = Number(message.patchCount);
    this.pointCount = Number(message.pointCount);
    this.patternPoints = Uint32Array.from(message.pattern?.points ?? []);
    this.patternTriangles = Uint32Array.from(message.pattern?.triangles ?? []);
    this.pointsPerPatch = this.patternPoints.length / 3;
    const first = [0];
    for (const run of message.chunkRuns) {
      for (let i = 0; i < run.chunkCount; ++i) first.push(first.at(-1)! + run.patchesPerChunk);
    }
    this.firstPatch = Uint32Array.from(first);
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

  pointsOf(chunk: number): number {
    return this.patchesOf(chunk) * this.pointsPerPatch;
  }

  firstPointOf(chunk: number): number {
    return this.firstPatch[chunk]! * this.pointsPerPatch;
  }
}

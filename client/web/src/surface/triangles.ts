// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { TopologyLayout } from './topology_layout';

/** Triangles over every `divisor`-th row of a patch's points, as a range of the indices. 1: over all points. */
export interface Detail {
  readonly divisor: number;
  readonly start: number;
  readonly count: number;
}

/** The triangles of all patches at each detail, in one index buffer. */
export interface Triangles {
  readonly indices: Uint32Array;
  /** The finest first. All patches have the same rows, so their edges meet at every detail. */
  readonly details: readonly Detail[];
}

export function trianglesOf(layout: TopologyLayout): Triangles {
  const { segments, patternTriangles, pointsPerPatch, patchCount } = layout;
  const divisors = Array.from({ length: segments }, (_, i) => i + 1).filter((divisor) => segments % divisor === 0);
  const patterns = divisors.map((divisor) => (divisor === 1 ? patternTriangles : coarsePattern(layout, divisor)));
  const indices = new Uint32Array(patchCount * patterns.reduce((sum, pattern) => sum + pattern.length, 0));
  let start = 0;
  const details = patterns.map((pattern, i) => {
    const count = patchCount * pattern.length;
    for (let patch = 0, at = start, first = 0; patch < patchCount; ++patch, first += pointsPerPatch) {
      for (let k = 0; k < pattern.length; ++k) indices[at++] = first + pattern[k]!;
    }
    start += count;
    return { divisor: divisors[i]!, start: start - count, count };
  });
  return { indices, details };
}

/** The pattern over the points whose barycentrics are multiples of `divisor`, wound like the pattern of all points. */
function coarsePattern({ segments, patternPoints }: TopologyLayout, divisor: number): Uint32Array {
  const numberOf = new Map<number, number>();
  const key = (i1: number, i2: number): number => i1 + (segments + 1) * i2;
  for (let n = 0; 3 * n < patternPoints.length; ++n) numberOf.set(key(patternPoints[3 * n + 1]!, patternPoints[3 * n + 2]!), n);
  const point = (i1: number, i2: number): number => numberOf.get(key(divisor * i1, divisor * i2))!;
  const rows = segments / divisor;
  const triangles: number[] = [];
  for (let i2 = 0; i2 < rows; ++i2) {
    for (let i1 = 0; i1 < rows - i2; ++i1) {
      triangles.push(point(i1, i2), point(i1 + 1, i2), point(i1, i2 + 1));
      if (i1 + 1 < rows - i2) triangles.push(point(i1 + 1, i2), point(i1 + 1, i2 + 1), point(i1, i2 + 1));
    }
  }
  return Uint32Array.from(triangles);
}

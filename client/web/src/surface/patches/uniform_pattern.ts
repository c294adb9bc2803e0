// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { TessellationPattern } from 'latticed/v1/event_pb';
import { cornersOf, packed, type PatchPattern } from './patch_pattern';

/**
 * The pattern of a view without a tolerance: the same segments along all edges of all patches. Its details take every n-th
 * row of points, for each n that divides the segments.
 */
export function uniformPattern({ points: flat, triangles }: TessellationPattern, segments: number): PatchPattern {
  const points = Uint32Array.from({ length: flat.length / 3 }, (_, n) => packed(flat[3 * n + 1]!, flat[3 * n + 2]!));
  const divisors = Array.from({ length: segments }, (_, i) => i + 1).filter((divisor) => segments % divisor === 0);
  const details = divisors.map((divisor) =>
    (divisor === 1 ? Uint16Array.from(triangles) : coarser(points, segments, divisor)));
  return { points, details, corners: cornersOf(points, segments) };
}

/** The triangles over the points whose barycentrics are multiples of `divisor`, wound like those over all points. */
function coarser(points: Uint32Array, segments: number, divisor: number): Uint16Array {
  const numberOf = new Map(Array.from(points, (entry, n) => [entry, n]));
  const point = (i1: number, i2: number): number => numberOf.get(packed(divisor * i1, divisor * i2))!;
  const rows = segments / divisor;
  const triangles: number[] = [];
  for (let i2 = 0; i2 < rows; ++i2) {
    for (let i1 = 0; i1 < rows - i2; ++i1) {
      triangles.push(point(i1, i2), point(i1 + 1, i2), point(i1, i2 + 1));
      if (i1 + 1 < rows - i2) triangles.push(point(i1 + 1, i2), point(i1 + 1, i2 + 1), point(i1, i2 + 1));
    }
  }
  return Uint16Array.from(triangles);
}

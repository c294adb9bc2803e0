// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { NUMBERS_PER_POINT } from '../decode/chunk_form';
import type { TopologyLayout } from './topology_layout';

/** Points as they are drawn: position = origin + number * step. */
export interface DrawnPoints {
  /** NUMBERS_PER_POINT per point, of which x y z are the first. */
  readonly numbers: ArrayLike<number>;
  readonly origin: readonly [number, number, number];
  readonly step: number;
}

/** Flat triangles to which distances are measured: nine numbers per patch, about `origin`. */
export interface FlatPatches {
  readonly origin: readonly [number, number, number];
  readonly corners: Float32Array;
}

/**
 * The largest distance of a point of the surface from the point with the same barycentrics in the flat triangle of its
 * patch. World units.
 *
 * @param points The points of a patch that are asked, by their number in the pattern.
 * @param stride Only every so many patches are asked.
 */
export function largestDistance(
  layout: TopologyLayout,
  drawn: DrawnPoints,
  flat: FlatPatches,
  points: readonly number[],
  stride: number,
): number {
  const weights = Float64Array.from(points.flatMap((point) => [...layout.patternPoints.subarray(3 * point, 3 * point + 3)]),
    (i) => i / layout.segments);
  const { numbers, step } = drawn;
  const { corners } = flat;
  const between = [0, 1, 2].map((axis) => drawn.origin[axis] - flat.origin[axis]);
  let largest = 0;
  for (let patch = 0; patch < layout.patchCount; patch += stride) {
    for (let i = 0; i < points.length; ++i) {
      const point = NUMBERS_PER_POINT * (patch * layout.pointsPerPatch + points[i]);
      let square = 0;
      for (let axis = 0; axis < 3; ++axis) {
        const at = 9 * patch + axis;
        const place = weights[3 * i] * corners[at] + weights[3 * i + 1] * corners[at + 3] + weights[3 * i + 2] * corners[at + 6];
        const away = between[axis] + step * numbers[point + axis] - place;
        square += away * away;
      }
      if (square > largest) largest = square;
    }
  }
  return Math.sqrt(largest);
}

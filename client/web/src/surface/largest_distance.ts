// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { NUMBERS_PER_POINT } from '../decode/chunk_form';
import { unpacked } from './patches/patch_pattern';
import type { PatchPlaces } from './patches/patch_places';

const PATCHES_ASKED = 10_000; // takes about a millisecond
const POINTS_ASKED = 1_000_000; // takes about 25 milliseconds

/** Points as they are drawn: position = origin + number * step. */
export interface DrawnPoints {
  readonly places: PatchPlaces;
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
 * @param asked Which points of a patch are asked.
 * @param stride Only every so many patches are asked.
 */
export function largestDistance(drawn: DrawnPoints, flat: FlatPatches, asked: 'corners' | 'all points', stride: number): number {
  const { places, numbers, step } = drawn;
  const { whole } = places.layout;
  const { corners } = flat;
  const between = [0, 1, 2].map((axis) => drawn.origin[axis] - flat.origin[axis]);
  let largest = 0;
  places.eachPatch(stride, (patch, pattern, firstPoint) => {
    const count = asked === 'corners' ? 3 : pattern.points.length;
    for (let i = 0; i < count; ++i) {
      const n = asked === 'corners' ? pattern.corners[i] : i;
      const [i1, i2] = unpacked(pattern.points[n]);
      const point = NUMBERS_PER_POINT * (firstPoint + n);
      let square = 0;
      for (let axis = 0; axis < 3; ++axis) {
        const at = 9 * patch + axis;
        const place = ((whole - i1 - i2) * corners[at] + i1 * corners[at + 3] + i2 * corners[at + 6]) / whole;
        const away = between[axis] + step * numbers[point + axis] - place;
        square += away * away;
      }
      if (square > largest) largest = square;
    }
  });
  return Math.sqrt(largest);
}

/** largestDistance at the corners of patches; with more than 10,000 patches, only of a part of them. */
export function largestAtCorners(drawn: DrawnPoints, flat: FlatPatches): number {
  return largestDistance(drawn, flat, 'corners', Math.ceil(drawn.places.layout.patchCount / PATCHES_ASKED));
}

/** largestDistance at all points; with more than a million, only of a part of the patches. */
export function largestAtPoints(drawn: DrawnPoints, flat: FlatPatches): number {
  return largestDistance(drawn, flat, 'all points', Math.ceil(drawn.places.pointCount / POINTS_ASKED));
}

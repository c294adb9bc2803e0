// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

import { MOST_LEVEL } from '../../surface/patches/adaptive_pattern';

/** Of an edge of which nothing is known. */
export const UNKNOWN_BEND = 255;

const LEVEL_BITS = 3;

/** The bound E of second derivatives along an edge, in world units (patches.proto, Levels). */
export function bendOf(byte: number, unit: number): number {
  return byte === UNKNOWN_BEND ? Infinity : unit * 2 ** (byte / 2);
}

/** The least level k with `bend` <= 6 tolerance 4^k, and at most 5. */
export function levelOf(bend: number, tolerance: number): number {
  let [level, reached] = [0, 6 * tolerance];
  while (level < MOST_LEVEL && !(bend <= reached)) {
    ++level;
    reached *= 4;
  }
  return level;
}

/** How far triangles may be from the surface at an edge of a level, as a part of its bend: 1 / (6 4^level). */
export function shrinkOf(level: number): number {
  return 4 ** -level / 6;
}

/** The codes of patches `first` to `end` - 1 (event.proto, PatchPattern; bit 9 is clear) from the levels of all edges. */
export function patternCodes(edges: Uint32Array, levels: Uint8Array, first: number, end: number): Uint16Array {
  const codes = new Uint16Array(end - first);
  for (let patch = first, at = 3 * first; patch < end; ++patch, at += 3) {
    codes[patch - first] = levels[edges[at]!]! | (levels[edges[at + 1]!]! << LEVEL_BITS) | (levels[edges[at + 2]!]! << (2 * LEVEL_BITS));
  }
  return codes;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** The largest level of an edge. */
export const MOST_LEVEL = 5;

/** Of an edge of which nothing is known. */
export const UNKNOWN_BEND = 255;

const LEVEL_BITS = 3;

/** The bound E of second derivatives along an edge, in world units (patches.proto, Levels). */
export function bendOf(byte: number, unit: number): number {
  return byte === UNKNOWN_BEND ? Infinity : unit * 2 ** (byte / 2);
}

/** The least level k with E <= 6 tolerance 4^k, and at most 5; for each byte of an edge. */
export function levelsFor(tolerance: number, unit: number): Uint8Array {
  return Uint8Array.from({ length: 256 }, (_, byte) => {
    const bend = bendOf(byte, unit);
    let level = 0;
    while (level < MOST_LEVEL && !(bend <= 6 * tolerance * 4 ** level)) ++level;
    return level;
  });
}

/** How far triangles may be from the surface at an edge of a level: E / (6 4^k), for each byte. In world units. */
export function errorsAt(level: number, unit: number): Float64Array {
  return Float64Array.from({ length: 256 }, (_, byte) => bendOf(byte, unit) / (6 * 4 ** level));
}

/** The codes of patches `first` to `end` - 1 (event.proto, PatchPattern; bit 9 is clear) from the levels of all edges. */
export function patternCodes(edges: Uint32Array, levels: Uint8Array, first: number, end: number): Uint16Array {
  const codes = new Uint16Array(end - first);
  for (let patch = first, at = 3 * first; patch < end; ++patch, at += 3) {
    codes[patch - first] = levels[edges[at]!]! | (levels[edges[at + 1]!]! << LEVEL_BITS) | (levels[edges[at + 2]!]! << (2 * LEVEL_BITS));
  }
  return codes;
}

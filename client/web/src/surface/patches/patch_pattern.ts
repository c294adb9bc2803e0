// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Points and triangles of one patch. Immutable, and shared by all patches that have them. */
export interface PatchPattern {
  /**
   * i_1 | i_2 << 16 of each point: its barycentrics in the patch's corners 1 and 2, times TopologyLayout.whole. That in
   * corner 0 is the rest.
   */
  readonly points: Uint32Array;
  /**
   * Triangles as triples of point numbers, of each detail, the finest first. All patterns of a layout have as many details,
   * and at each of them neighbours meet in the same points.
   */
  readonly details: readonly Uint16Array[];
  /** The numbers of the points at corners 0, 1, 2. */
  readonly corners: readonly [number, number, number];
}

/** The number of points of a pattern. */
export function pointsIn({ points }: PatchPattern): number {
  return points.length;
}

/** One entry of PatchPattern.points. Both are below 65,536. */
export function packed(i1: number, i2: number): number {
  return i1 | (i2 << 16);
}

/** i_1 and i_2 of an entry of PatchPattern.points. */
export function unpacked(entry: number): [number, number] {
  return [entry & 0xffff, entry >>> 16];
}

/** The numbers of the points at the three corners. */
export function cornersOf(points: Uint32Array, whole: number): [number, number, number] {
  return [points.indexOf(packed(0, 0)), points.indexOf(packed(whole, 0)), points.indexOf(packed(0, whole))];
}

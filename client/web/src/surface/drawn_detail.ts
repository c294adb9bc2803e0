// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { BufferGeometry } from 'three';
import type { PatchPlaces } from './patches/patch_places';

/** Draws a detail by its number, or the coarsest if there are fewer. */
export function setDetail(geometry: BufferGeometry, { details }: PatchPlaces, detail: number): void {
  const { start, count } = details[Math.min(detail, details.length - 1)]!;
  geometry.setDrawRange(start, count);
}

/**
 * Draws with at most this number of triangles, and then as before. Where only a much coarser detail has so few, as with
 * adaptive patterns of few patches, the next finer one is drawn.
 */
export function drawCoarsely(geometry: BufferGeometry, places: PatchPlaces, triangles: number, draw: () => void): void {
  const { start, count } = geometry.drawRange;
  const counts = places.triangleCounts;
  const few = counts.findIndex((all) => all <= triangles);
  let detail = few < 0 ? counts.length - 1 : few;
  if (detail > 0 && counts[detail]! < triangles / 4 && counts[detail - 1]! <= 8 * triangles) --detail;
  const coarse = places.details[detail]!;
  if (coarse.count < count) geometry.setDrawRange(coarse.start, coarse.count);
  draw();
  geometry.setDrawRange(start, count);
}

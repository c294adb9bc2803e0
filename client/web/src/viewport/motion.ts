// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How coarsely frames are drawn while something moves: as coarse as the time of frames asks for. The surface is drawn over
// fewer rows of the points that are there, and the view with fewer pixels, whichever costs more.

const BUDGET_MS = 33; // of a frame, at 30 frames per second
const RATIOS = [1, 0.7, 0.5]; // of the pixels along each side
const PIXELS_PER_TRIANGLE = 5; // a triangle costs about as much as this number of pixels

/** What only adds shades to the surface: drawn anew, as the frame before left it, or left out, which is quickest. */
export type Shades = 'new' | 'kept' | 'none';

/** A shape with fewer triangles at coarser details. */
export interface Coarsened {
  /** The number of triangles of each detail, the finest first. */
  readonly triangles: readonly number[];
  /** Draws this detail, with these shades, from the next frame on. */
  setDetail(detail: number, shades: Shades): void;
}

/** Numbers of a detail and of a ratio of pixels; 0 is the finest. */
export interface Plan {
  readonly detail: number;
  readonly ratio: number;
}

export const FINEST: Plan = { detail: 0, ratio: 0 };

export function pixelRatioOf(plan: Plan): number {
  return RATIOS[plan.ratio];
}

/** A plan that keeps the budget, if one does; `plan` itself if it does. Measured: a frame at `plan` took `ms`. `pixels`: those of the view at ratio 1. */
export function planFor(plan: Plan, ms: number, triangles: readonly number[], pixels: number): Plan {
  let { detail, ratio } = plan;
  const ofTriangles = (): number => PIXELS_PER_TRIANGLE * (triangles[detail] ?? 0);
  const ofPixels = (): number => pixels * RATIOS[ratio] ** 2;
  const allowed = ((ofTriangles() + ofPixels()) * BUDGET_MS) / ms;
  while (ofTriangles() + ofPixels() > allowed) {
    const [hasDetail, hasRatio] = [detail + 1 < triangles.length, ratio + 1 < RATIOS.length];
    if (hasDetail && (!hasRatio || ofTriangles() > ofPixels())) ++detail;
    else if (hasRatio) ++ratio;
    else break;
  }
  return detail === plan.detail && ratio === plan.ratio ? plan : { detail, ratio };
}

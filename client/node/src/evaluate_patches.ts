// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points and triangles of all patches, within a tolerance of the exact surface: patches.proto. Evaluated in double.
import { BsplineVolume } from './bspline_volume.js';
import type { Lattice__Output } from './generated/latticed/v1/Lattice.js';
import type { PatchPlan } from './patch_plan.js';
import { splitPatch, WHOLE, type Point } from './split_patch.js';

const UNITS = 65535;  // places of a span

export interface Triangles {
  points: [number, number, number][];
  triangles: number[];  // three indices of points each, counter-clockwise from outside
}

/** lattice: with the control points of effective_points.ts. edgeBytes: the data of all chunks, in the order of edges. */
export function evaluatePatches(
  plan: PatchPlan, lattice: Lattice__Output, edgeBytes: Uint8Array, tolerance: number): Triangles {
  if (edgeBytes.length !== plan.edgeCount) throw new Error(`${plan.edgeCount} edges have ${edgeBytes.length} bytes`);
  const { mode } = lattice.outside ?? {};
  if (mode !== undefined && mode !== 'OUTSIDE_MODE_UNSPECIFIED' && mode !== 'OUTSIDE_MODE_FIXED') {
    throw new Error('this example has no lattices that go on outside their frame: lattice.outside is set');
  }
  const volume = new BsplineVolume(lattice);
  const levels = Array.from(edgeBytes, (byte) => plan.levelOf(byte, tolerance));
  const points: Triangles['points'] = [];
  const triangles: number[] = [];
  for (let patch = 0; patch < plan.patches; ++patch) {
    const [a, b, c] = plan.edges.slice(3 * patch, 3 * patch + 3).map((edge) => levels[edge]!);
    const pattern = splitPatch(a! + 8 * b! + 64 * c!);
    for (const number of pattern.triangles) triangles.push(points.length + number);
    const places = plan.corners.slice(3 * patch, 3 * patch + 3).map((vertex) => plan.places[vertex]!);
    for (const point of pattern.points) points.push(evaluate(volume, places, point));
  }
  return { points, triangles };
}

// All sums are exact. So a point that patches share has the same bits in all of them.
function evaluate(volume: BsplineVolume, places: number[][], point: Point): [number, number, number] {
  const spans: number[] = [], local: number[] = [];
  for (let axis = 0; axis < 3; ++axis) {
    const [p, q, r] = places.map((place) => place[axis]!) as [number, number, number];
    let span = Math.max(0, Math.ceil((p + q + r) / (3 * UNITS)) - 1);
    const low = UNITS * span;
    let n = point[0] * (p - low) + point[1] * (q - low) + point[2] * (r - low);
    if (n === 0 && span > 0) {  // the next lower box owns the points of its upper face
      n = UNITS * WHOLE;
      --span;
    }
    spans.push(span);
    local.push((2 * n - UNITS * WHOLE) / (2 * UNITS * WHOLE));
  }
  return volume.at(spans, local);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns a motion of the selected control points into one edit: an offset or a matrix if all points share it, else
// positions. Soft selection, mirrors and the pivot 'each' move points differently.

import type { Lattice } from '../lattice/lattice';
import { add, pointAt, sub, type Vec3 } from '../lattice/vec';
import type { LatticeEdit } from '../session/edits/lattice_edit';
import { softWeights, type SoftSelection, type Weighted } from './falloff';
import { mirrored, type Mirror } from './mirror';
import { moved, motionMatrix, type Motion } from './motion';
import type { Pivot } from './pivot';

/** How a gesture spreads from the selected points, as of its begin. `start` holds all points at the begin. */
export interface Spread {
  readonly lattice: Lattice;
  readonly start: Float64Array;
  readonly selected: Uint32Array;
  readonly weighted: readonly Weighted[];
  readonly mirror: Mirror;
  readonly pivot: Pivot;
}

export function beginSpread(
  lattice: Lattice,
  selected: Uint32Array,
  options: { soft: SoftSelection; mirror: Mirror; pivot: Pivot },
  isHidden: (index: number) => boolean,
): Spread {
  const start = lattice.points.slice();
  const weighted = softWeights(start, selected, options.soft, isHidden);
  return { lattice, start, selected, weighted, mirror: options.mirror, pivot: options.pivot };
}

/** The same gesture with another soft selection. */
export function respread(spread: Spread, soft: SoftSelection, isHidden: (index: number) => boolean): Spread {
  return { ...spread, weighted: softWeights(spread.start, spread.selected, soft, isHidden) };
}

/** The edit that applies a motion about `center` to the points at the gesture's begin. */
export function buildEdit(spread: Spread, motion: Motion, center: Vec3): LatticeEdit {
  const alike = spread.weighted.length === spread.selected.length && !spread.mirror.includes(true);
  if (alike && motion.kind === 'move') return { kind: 'move', indices: spread.selected, offset: motion.offset };
  if (alike && spread.pivot !== 'each') {
    return { kind: 'transform', indices: spread.selected, matrix: motionMatrix(motion, center) };
  }
  return positionsEdit(spread, mirrored(spread.lattice, displacements(spread, motion, center), spread.mirror));
}

function displacements(spread: Spread, motion: Motion, center: Vec3): Map<number, Vec3> {
  const found = new Map<number, Vec3>();
  for (const { index, weight, leader } of spread.weighted) {
    const p = pointAt(spread.start, index);
    const pivot = spread.pivot === 'each' ? pointAt(spread.start, leader) : center;
    found.set(index, sub(moved(motion, pivot, p, weight), p));
  }
  return found;
}

function positionsEdit(spread: Spread, displacement: ReadonlyMap<number, Vec3>): LatticeEdit {
  const indices = Uint32Array.from(displacement.keys()).sort();
  const positions = new Float64Array(3 * indices.length);
  indices.forEach((index, i) => positions.set(add(pointAt(spread.start, index), displacement.get(index)!), 3 * i));
  return { kind: 'set', indices, positions };
}

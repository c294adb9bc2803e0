// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Mirrored editing: a move of a control point also moves its mirror images, reflected in the middle of the rest frame.

import { mirrorImage } from '../lattice/index_sets';
import { AXES, frameEdges, placeOf, type Axis, type LatticeStructure } from '../lattice/grid';
import { add, combine, coordinates, scale, type MutableVec3, type Vec3 } from '../lattice/vec';

/** Whether edits are mirrored along u, v and w. */
export type Mirror = readonly [boolean, boolean, boolean];

/** Switches one axis on or off. */
export function switchedMirror(mirror: Mirror, axis: Axis): Mirror {
  return mirror.map((on, i) => (i === axis ? !on : on)) as unknown as Mirror;
}

/** Reflects a displacement: its components along the frame's edges of `axes` change sign. */
export function reflected(structure: LatticeStructure, displacement: Vec3, axes: readonly Axis[]): Vec3 {
  const edges = frameEdges(structure.frame);
  const x = coordinates(edges, displacement) as MutableVec3;
  for (const axis of axes) x[axis] = -x[axis];
  return combine(edges, x);
}

/**
 * Adds the mirror images to `displacements` (by control point). A point that is displaced itself keeps its
 * displacement. A point in the middle of a mirrored axis stays in the middle.
 */
export function mirrored(structure: LatticeStructure, displacements: Map<number, Vec3>, mirror: Mirror): Map<number, Vec3> {
  const all = new Map<number, Vec3>();
  for (const [index, displacement] of displacements)
    all.set(index, keptInMiddle(structure, index, displacement, mirror));
  for (const axes of subsets(AXES.filter((axis) => mirror[axis]))) {
    for (const index of displacements.keys()) {
      const image = mirrorImage(structure.size, index, axes);
      if (!all.has(image)) all.set(image, reflected(structure, all.get(index)!, axes));
    }
  }
  return all;
}

function keptInMiddle(structure: LatticeStructure, index: number, displacement: Vec3, mirror: Mirror): Vec3 {
  const place = placeOf(structure.size, index);
  let kept = displacement;
  for (const axis of AXES) {
    if (!mirror[axis] || 2 * place[axis] !== structure.size[axis] - 1) continue;
    kept = scale(add(kept, reflected(structure, kept, [axis])), 0.5);
  }
  return kept;
}

/** All subsets that are not empty. */
function subsets(axes: readonly Axis[]): Axis[][] {
  const found: Axis[][] = [];
  for (let bits = 1; bits < 1 << axes.length; ++bits) found.push(axes.filter((_, i) => (bits >> i) & 1));
  return found;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { add, pointAt, type Vec3 } from '../../lattice/vec';
import type { LatticeEdit } from './lattice_edit';

/** Positions of control points after an edit: x y z per index, world units; and the scene's strength, if it sets one. */
export interface Targets {
  readonly indices: Uint32Array;
  readonly positions: Float64Array;
  readonly strength?: number;
}

const NO_POINTS: Targets = { indices: new Uint32Array(), positions: new Float64Array() };

/** The targets of an edit, as the server computes them; undefined for a drag, which only the server can solve. */
export function targetsOf(edit: LatticeEdit, points: Float64Array): Targets | undefined {
  switch (edit.kind) {
    case 'set': return { indices: edit.indices, positions: edit.positions };
    case 'move': return moved(edit.indices, points, (point) => add(point, edit.offset));
    case 'transform': return moved(edit.indices, points, ([x, y, z]) => {
      const m = edit.matrix;
      return [0, 1, 2].map((row) => m[row]! * x + m[4 + row]! * y + m[8 + row]! * z + m[12 + row]!);
    });
    case 'strength': return { ...NO_POINTS, strength: edit.strength };
    case 'drag': return undefined;
  }
}

/** Adds to `targets` the points of `touched` that it lacks, at their places in `points`. */
export function withRestored(targets: Targets, touched: Iterable<number>, points: Float64Array): Targets {
  const present = new Set(targets.indices);
  const restored = Array.from(touched).filter((index) => !present.has(index));
  if (!restored.length) return targets;
  const indices = new Uint32Array([...targets.indices, ...restored]);
  const positions = new Float64Array(3 * indices.length);
  positions.set(targets.positions);
  restored.forEach((index, i) =>
    positions.set(points.subarray(3 * index, 3 * index + 3), targets.positions.length + 3 * i));
  return { ...targets, indices, positions };
}

function moved(indices: Uint32Array, points: Float64Array, map: (point: Vec3) => ArrayLike<number>): Targets {
  const positions = new Float64Array(3 * indices.length);
  indices.forEach((index, i) => positions.set(map(pointAt(points, index)), 3 * i));
  return { indices, positions };
}

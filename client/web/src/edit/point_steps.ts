// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Steps from control point to control point by the arrow keys: to the right, up, and away from the viewer.
import { AXES, frameEdges, indexOf, placeOf, type Axes, type Axis } from '../lattice/grid';
import type { LatticeFrame } from '../lattice/lattice';
import { dot, normalized, pointAt, type Basis, type Vec3 } from '../lattice/vec';

/** 0 is right, 1 is up, 2 is towards the viewer, as in the view's basis; `sign` -1 is the other way. */
export interface StepKey {
  readonly direction: 0 | 1 | 2;
  readonly sign: 1 | -1;
}

/** The step of an arrow key; undefined for other keys. `deep`: up and down step away and back. */
export function stepOfKey(key: string, deep: boolean): StepKey | undefined {
  switch (key) {
    case 'ArrowRight': return { direction: 0, sign: 1 };
    case 'ArrowLeft': return { direction: 0, sign: -1 };
    case 'ArrowUp': return deep ? { direction: 2, sign: -1 } : { direction: 1, sign: 1 };
    case 'ArrowDown': return deep ? { direction: 2, sign: 1 } : { direction: 1, sign: -1 };
    default: return undefined;
  }
}

/** The lattice's axis for each direction of the view, each once, and whether it rises or falls along the direction. */
export function axesInView(frame: LatticeFrame, view: Basis): readonly { readonly axis: Axis; readonly sign: 1 | -1 }[] {
  const edges = frameEdges(frame).map(normalized);
  const left = new Set<Axis>(AXES);
  return view.map((direction) => {
    const along = (axis: Axis): number => dot(edges[axis], direction);
    const axis = [...left].reduce((best, each) => (Math.abs(along(each)) > Math.abs(along(best)) ? each : best));
    left.delete(axis);
    return { axis, sign: along(axis) < 0 ? -1 : 1 };
  });
}

/** The next point of the grid along an axis that is not hidden; undefined at the grid's end. */
export function nextPoint(size: Axes, index: number, axis: Axis, sign: 1 | -1, isHidden: (index: number) => boolean): number | undefined {
  const place = placeOf(size, index);
  for (place[axis] += sign; place[axis] >= 0 && place[axis] < size[axis]; place[axis] += sign) {
    const next = indexOf(size, place);
    if (!isHidden(next)) return next;
  }
  return undefined;
}

/** The point that is farthest along a direction, of those that are not hidden. */
export function foremost(points: ArrayLike<number>, direction: Vec3, isHidden: (index: number) => boolean): number | undefined {
  let [best, most]: [number | undefined, number] = [undefined, -Infinity];
  for (let index = 0; index < points.length / 3; ++index) {
    const along = dot(pointAt(points, index), direction);
    if (along > most && !isHidden(index)) [best, most] = [index, along];
  }
  return best;
}

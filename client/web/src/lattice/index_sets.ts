// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sets of control points by their place in the grid: rows, planes, inner points, mirror images, grid lines.

import { AXES, indexOf, placeOf, pointCount, type Axes, type Axis } from './grid';

/** 0 to count - 1. */
export function indicesTo(count: number): number[] {
  return Array.from({ length: count }, (_, i) => i);
}

/** The row through a control point along an axis. */
export function rowOf(size: Axes, index: number, axis: Axis): number[] {
  const place = placeOf(size, index);
  return Array.from({ length: size[axis] }, (_, i) => {
    place[axis] = i;
    return indexOf(size, place);
  });
}

/** The plane through a control point across an axis: all points with the same place along that axis. */
export function planeOf(size: Axes, index: number, axis: Axis): number[] {
  const at = placeOf(size, index)[axis];
  return indicesTo(pointCount(size)).filter((i) => placeOf(size, i)[axis] === at);
}

/** Points that lie on none of the grid's six faces. */
export function innerPoints(size: Axes): number[] {
  return indicesTo(pointCount(size)).filter((i) => placeOf(size, i).every((at, axis) => at > 0 && at < size[axis] - 1));
}

/** The control point on the other side of the grid's middle along each of `axes`. */
export function mirrorImage(size: Axes, index: number, axes: readonly Axis[]): number {
  const place = placeOf(size, index);
  for (const axis of axes) place[axis] = size[axis] - 1 - place[axis];
  return indexOf(size, place);
}

/** Index pairs of the lines between neighbours, for one line list. Lines at a hidden point are left out. */
export function gridLines(size: Axes, hidden: (index: number) => boolean): Uint32Array {
  const pairs: number[] = [];
  const steps: Axes = [1, size[0], size[0] * size[1]];
  for (let index = 0; index < pointCount(size); ++index) {
    if (hidden(index)) continue;
    const place = placeOf(size, index);
    for (const axis of AXES) {
      const next = index + steps[axis];
      if (place[axis] + 1 < size[axis] && !hidden(next)) pairs.push(index, next);
    }
  }
  return Uint32Array.from(pairs);
}

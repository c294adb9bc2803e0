// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What edits of a scene keep. The server honours it; the page shows it, and moves nothing that is held.
import { AXES, placeOf, pointCount, type Axes, type Axis } from './grid';
import { mirrorImage } from './index_sets';

export interface HeldLayers {
  readonly axis: Axis;
  readonly atEnd: boolean;
  readonly layers: number;
}

export interface Constraints {
  /** Control points. */
  readonly held: readonly number[];
  readonly layers: readonly HeldLayers[];
  /** Control points of this axis move as mirror images. */
  readonly mirror?: Axis | undefined;
  /** The enclosed volume is kept. `volume`: which one, absent: that at rest. `axis`: by moves along this axis only. */
  readonly volume?: { readonly volume?: number | undefined; readonly axis?: Axis | undefined } | undefined;
}

export const NO_CONSTRAINTS: Constraints = { held: [], layers: [] };

/** The control points that no edit moves: those that are held, or whose mirror image is. */
export function heldPoints(size: Axes, { held, layers, mirror }: Constraints): Set<number> {
  const all = new Set(held);
  for (let index = 0; layers.length > 0 && index < pointCount(size); ++index) {
    const place = placeOf(size, index);
    const isIn = ({ axis, atEnd, layers: count }: HeldLayers): boolean =>
      (atEnd ? size[axis] - 1 - place[axis] : place[axis]) < count;
    if (layers.some(isIn)) all.add(index);
  }
  if (mirror !== undefined) for (const index of [...all]) all.add(mirrorImage(size, index, [mirror]));
  return all;
}

/** The constraints with this number of layers held at both faces of each axis; 0: at none. */
export function withLayers(constraints: Constraints, count: number): Constraints {
  const layers = count === 0 ? [] : AXES.flatMap((axis) => [false, true].map((atEnd) => ({ axis, atEnd, layers: count })));
  return { ...constraints, layers };
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A running transform, a dragged handle or a pull in words, for the line below the view.

import { AXIS_NAMES } from '../lattice/grid';
import { length, sub, type Vec3 } from '../lattice/vec';
import { axesMeant, type Constraint } from './constraint';
import type { Motion } from './motion';
import type { Orientation } from './pivot';
import type { SurfacePull } from './surface_pull';
import type { TransformSession } from './transform_session';

const VERBS = { move: 'Move', rotate: 'Rotate', scale: 'Scale' } as const;
const NOTHING = 5e-4; // a component below this fraction of a move is rounding

export function transformHeadline(transform: TransformSession, orientation: Orientation): string {
  const { typed, constraint, trackball, kind } = transform;
  const verb = trackball ? 'Trackball' : VERBS[kind];
  const amount = typed.text === '' ? amountText(transform.motion()) : `${typed.text}${kind === 'rotate' ? ' °' : ''}`;
  return `${verb}  ${amount}${constraintText(constraint, orientation)}`;
}

/** The line for a dragged handle. `constraint`: the handle's axis or plane. */
export function handleHeadline(motion: Motion, constraint: Constraint | undefined, orientation: Orientation): string {
  return `${VERBS[motion.kind]}  ${amountText(motion)}${constraintText(constraint, orientation)}`;
}

/** The line for a pull at the surface. */
export function pullHeadline({ point, target, outOfReach }: Pick<SurfacePull, 'point' | 'target' | 'outOfReach'>): string {
  const missed = outOfReach > 0 ? `   out of reach by ${rounded(outOfReach)}: outside the lattice` : '';
  return `Pull  ${wayText(sub(target, point.position))}${missed}`;
}

function amountText(motion: Motion): string {
  switch (motion.kind) {
    case 'move':
      return wayText(motion.offset);
    case 'rotate':
      return `${((motion.angle * 180) / Math.PI).toFixed(1)}°`;
    case 'scale':
      return motion.factors.map(rounded).join('  ');
  }
}

function wayText(offset: Vec3): string {
  const way = length(offset);
  const parts = offset.map((x) => (Math.abs(x) < NOTHING * way ? '0' : rounded(x)));
  return `${parts.join('  ')}   (${rounded(way)})`;
}

function constraintText(constraint: Constraint | undefined, orientation: Orientation): string {
  if (constraint === undefined) return '';
  const axes = axesMeant(constraint, orientation);
  const name = axes === 'lattice' ? AXIS_NAMES[constraint.axis] : 'XYZ'[constraint.axis];
  return constraint.plane ? `   in the plane across ${name} (${axes})` : `   along ${name} (${axes})`;
}

function rounded(x: number): string {
  return Number(x.toPrecision(4)).toString();
}

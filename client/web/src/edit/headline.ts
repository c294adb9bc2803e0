// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A running transform in words, for the line below the view.

import { AXIS_NAMES } from '../lattice/grid';
import { length } from '../lattice/vec';
import type { Constraint } from './constraint';
import type { Motion } from './motion';
import type { Orientation } from './pivot';

const VERBS = { move: 'Move', rotate: 'Rotate', scale: 'Scale' } as const;

export function transformHeadline(
  motion: Motion,
  constraint: Constraint | undefined,
  orientation: Orientation,
  typed: string,
): string {
  const amount = typed === '' ? amountText(motion) : `${typed}|${motion.kind === 'rotate' ? '°' : ''}`;
  return `${VERBS[motion.kind]}  ${amount}${constraintText(constraint, orientation)}`;
}

function amountText(motion: Motion): string {
  switch (motion.kind) {
    case 'move':
      return `${motion.offset.map(rounded).join('  ')}   (${rounded(length(motion.offset))})`;
    case 'rotate':
      return `${((motion.angle * 180) / Math.PI).toFixed(1)}°`;
    case 'scale':
      return motion.factors.map(rounded).join('  ');
  }
}

function constraintText(constraint: Constraint | undefined, orientation: Orientation): string {
  if (constraint === undefined) return '';
  const axes = constraint.local ? 'lattice' : orientation;
  const name = axes === 'lattice' ? AXIS_NAMES[constraint.axis] : 'XYZ'[constraint.axis];
  return constraint.plane ? `   in the plane across ${name} (${axes})` : `   along ${name} (${axes})`;
}

function rounded(x: number): string {
  return Number(x.toPrecision(4)).toString();
}

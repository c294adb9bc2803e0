// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The axis, or the plane across an axis, that a transform keeps to. The first press of a key takes the axes of the
// chosen orientation. The second press takes the lattice's axes, or the world's if the lattice's are chosen.

import { AXES, type Axis } from '../lattice/grid';
import { dot, type Vec3 } from '../lattice/vec';
import type { Orientation } from './pivot';

export interface Constraint {
  axis: Axis;
  /** Keeps to the plane across the axis, not to the axis. */
  plane: boolean;
  /** Whether the axes are those of the second press. */
  second: boolean;
}

/** The constraint after X, Y or Z is pressed: once, again for the second axes, a third time for none. */
export function nextConstraint(now: Constraint | undefined, axis: Axis, plane: boolean): Constraint | undefined {
  if (now === undefined || now.axis !== axis || now.plane !== plane) return { axis, plane, second: false };
  return now.second ? undefined : { ...now, second: true };
}

/** The axes along which points may move. */
export function freeAxes(constraint: Constraint | undefined): readonly Axis[] {
  if (constraint === undefined) return AXES;
  return constraint.plane ? AXES.filter((a) => a !== constraint.axis) : [constraint.axis];
}

/** Pixels per world unit at the pivot: row 0 to the right, row 1 down. */
export type ScreenJacobian = readonly [Vec3, Vec3];

/** The amount along `axis` whose projection best follows a pointer move of `dx`, `dy` pixels. */
export function amountAlong(jacobian: ScreenJacobian, axis: Vec3, dx: number, dy: number): number {
  const sx = dot(jacobian[0], axis);
  const sy = dot(jacobian[1], axis);
  // An axis towards the viewer is almost a point on the screen: the lower bound keeps the amount small.
  const least = 0.1 * Math.max(norm(jacobian[0]), norm(jacobian[1]));
  return (sx * dx + sy * dy) / Math.max(sx * sx + sy * sy, least * least);
}

/** The amounts along two axes that follow the pointer. If their plane is seen edge-on, only one axis moves. */
export function amountsInPlane(jacobian: ScreenJacobian, a: Vec3, b: Vec3, dx: number, dy: number): [number, number] {
  const [ax, ay, bx, by] = [dot(jacobian[0], a), dot(jacobian[1], a), dot(jacobian[0], b), dot(jacobian[1], b)];
  const determinant = ax * by - ay * bx;
  const aPixels = Math.hypot(ax, ay);
  const bPixels = Math.hypot(bx, by);
  if (Math.abs(determinant) < 0.1 * norm(jacobian[0]) * norm(jacobian[1])) {
    return aPixels > bPixels ? [amountAlong(jacobian, a, dx, dy), 0] : [0, amountAlong(jacobian, b, dx, dy)];
  }
  return [(dx * by - dy * bx) / determinant, (dy * ax - dx * ay) / determinant];
}

function norm(v: Vec3): number {
  return Math.hypot(...v);
}

/** The orientation that a second press of X, Y or Z takes. */
export function secondOrientation(chosen: Orientation): Orientation {
  return chosen === 'lattice' ? 'world' : 'lattice';
}

/** The orientation whose axes a constraint keeps to. */
export function axesMeant(constraint: Constraint, chosen: Orientation): Orientation {
  return constraint.second ? secondOrientation(chosen) : chosen;
}

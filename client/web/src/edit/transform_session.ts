// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One running transform, as in Blender: G, R or S begins it; the pointer or a typed number says how much; X, Y, Z and
// Shift with them say along what; Enter or a click confirms, Esc or a right click cancels. Pure: a picture of the view
// at the pivot goes in, a motion comes out.

import type { Axis } from '../lattice/grid';
import { combine, dot, type Basis, type MutableVec3, type Vec3 } from '../lattice/vec';
import {
  amountAlong,
  amountsInPlane,
  constraintBasis,
  freeAxes,
  nextConstraint,
  type Constraint,
  type ScreenJacobian,
} from './constraint';
import type { Motion, MotionKind } from './motion';
import { NumericEntry } from './numeric_entry';

export interface TransformView {
  /** Right, up and towards the viewer, unit vectors in the world. */
  basis: Basis;
  jacobian: ScreenJacobian;
  /** The pivot's place, in pixels. */
  pivot: [number, number];
  /** What X, Y and Z mean, and what they mean when pressed twice. */
  axes: Basis;
  localAxes: Basis;
  /** The step of a snapped move, in world units. */
  snapStep: number;
}

export interface Modifiers {
  shift: boolean;
  ctrl: boolean;
}

export type Outcome = 'running' | 'confirmed' | 'cancelled';

const FINE = 0.1;
const AXIS_KEYS = 'xyz';
const KIND_KEYS: Record<string, MotionKind> = { g: 'move', r: 'rotate', s: 'scale' };
const SNAP_ANGLE = Math.PI / 36; // 5 degrees
const SNAP_FACTOR = 0.1;
const LEAST_RADIUS = 20; // pixels: a scaling that begins on the pivot would leap

export class TransformSession {
  constraint: Constraint | undefined;
  readonly typed = new NumericEntry();
  private at: [number, number];
  private way: [number, number] = [0, 0]; // in pixels, with the fine parts made smaller
  private turn = 0;
  private factor = 1;
  private readonly startRadius: number;
  private snapping = false;
  private fine = false;

  constructor(
    public kind: MotionKind,
    private readonly view: TransformView,
    pointer: [number, number],
  ) {
    this.at = pointer;
    this.startRadius = Math.max(Math.hypot(pointer[0] - view.pivot[0], pointer[1] - view.pivot[1]), LEAST_RADIUS);
  }

  /** Follows the pointer to a place in pixels. */
  pointer(x: number, y: number, modifiers: Modifiers): void {
    const speed = modifiers.shift ? FINE : 1;
    const [px, py] = this.view.pivot;
    const before = [this.at[0] - px, this.at[1] - py] as const;
    const after = [x - px, y - py] as const;
    this.way[0] += (after[0] - before[0]) * speed;
    this.way[1] += (after[1] - before[1]) * speed;
    this.turn += signedAngle(before, after) * speed;
    this.factor += ((Math.hypot(...after) - Math.hypot(...before)) / this.startRadius) * speed;
    this.at = [x, y];
    this.snapping = modifiers.ctrl;
    this.fine = modifiers.shift;
  }

  /** Takes a key by the name that KeyboardEvent.key gives it; undefined where it means nothing here. */
  key(key: string, shift: boolean): Outcome | undefined {
    if (key === 'Enter') return 'confirmed';
    if (key === 'Escape') return 'cancelled';
    const letter = key.toLowerCase();
    const axis = AXIS_KEYS.indexOf(letter);
    if (letter.length === 1 && axis >= 0) {
      this.constraint = nextConstraint(this.constraint, axis as Axis, shift);
      return 'running';
    }
    if (KIND_KEYS[letter] !== undefined) {
      this.kind = KIND_KEYS[letter];
      return 'running';
    }
    return this.typed.key(key) ? 'running' : undefined;
  }

  /** What the transform does as it stands. */
  motion(): Motion {
    const basis = constraintBasis(this.constraint, this.view.axes, this.view.localAxes);
    switch (this.kind) {
      case 'move':
        return { kind: 'move', offset: this.offset(basis) };
      case 'rotate':
        return { kind: 'rotate', axis: this.axis(basis), angle: this.angle(basis) };
      case 'scale':
        return { kind: 'scale', basis, factors: this.factors() };
    }
  }

  private offset(basis: Basis): Vec3 {
    const axes = freeAxes(this.constraint);
    const [dx, dy] = this.way;
    const x: MutableVec3 = [0, 0, 0];
    if (this.typed.value !== undefined) {
      // Without a constraint a number is along X, as in Blender.
      x[axes[0]] = this.typed.value;
      return combine(basis, x);
    }
    if (axes.length === 3) {
      const [right, up] = this.view.basis;
      const [along, upward] = amountsInPlane(this.view.jacobian, right, up, dx, dy);
      return this.snappedOffset(combine(this.view.basis, [along, upward, 0]));
    }
    if (axes.length === 1) {
      x[axes[0]] = this.snapped(amountAlong(this.view.jacobian, basis[axes[0]], dx, dy), this.view.snapStep);
    } else {
      const [a, b] = axes as [Axis, Axis];
      const [s, t] = amountsInPlane(this.view.jacobian, basis[a], basis[b], dx, dy);
      x[a] = this.snapped(s, this.view.snapStep);
      x[b] = this.snapped(t, this.view.snapStep);
    }
    return combine(basis, x);
  }

  private snappedOffset(offset: Vec3): Vec3 {
    return offset.map((x) => this.snapped(x, this.view.snapStep)) as unknown as Vec3;
  }

  /** Without a constraint turns are about the line of sight; a plane turns about its normal. */
  private axis(basis: Basis): Vec3 {
    return this.constraint === undefined ? this.view.basis[2] : basis[this.constraint.axis];
  }

  private angle(basis: Basis): number {
    if (this.typed.value !== undefined) return (this.typed.value * Math.PI) / 180;
    // The pointer turns about the line of sight: an axis that points away turns the other way round.
    const towards = dot(this.axis(basis), this.view.basis[2]) >= 0 ? 1 : -1;
    return towards * this.snapped(this.turn, SNAP_ANGLE);
  }

  private factors(): Vec3 {
    const factor = this.typed.value ?? this.snapped(this.factor, SNAP_FACTOR);
    const factors: MutableVec3 = [1, 1, 1];
    for (const axis of freeAxes(this.constraint)) factors[axis] = factor;
    return factors;
  }

  private snapped(amount: number, step: number): number {
    if (!this.snapping) return amount;
    const size = this.fine ? step * FINE : step;
    return Math.round(amount / size) * size;
  }
}

/** Counter-clockwise on a screen whose y points down. */
function signedAngle(from: readonly [number, number], to: readonly [number, number]): number {
  return -Math.atan2(from[0] * to[1] - from[1] * to[0], from[0] * to[0] + from[1] * to[1]);
}

/** A step of 1, 2 or 5 times a power of ten that is about `pixels` wide where a unit is `pixelsPerUnit`. */
export function snapStep(pixelsPerUnit: number, pixels = 24): number {
  const wanted = pixels / pixelsPerUnit;
  const power = 10 ** Math.floor(Math.log10(wanted));
  return power * ([1, 2, 5, 10].find((m) => m * power >= wanted) ?? 10);
}

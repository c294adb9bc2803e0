// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One running transform, as in Blender. G, R or S begins it; R again makes it a trackball. The pointer or typed numbers
// give the amount. X, Y, Z, also with Shift, constrain it. Enter or a click confirms, Esc or a right click cancels.
// Pure: takes the view at the pivot, returns a motion.

import type { Axis } from '../lattice/grid';
import { add, combine, dot, length, normalized, scale, type Basis, type MutableVec3, type Vec3 } from '../lattice/vec';
import {
  amountAlong,
  amountsInPlane,
  freeAxes,
  nextConstraint,
  type Constraint,
  type ScreenJacobian,
} from './constraint';
import type { Motion, MotionKind } from './motion';
import { PointerTravel } from './pointer_travel';
import { TypedAmounts } from './typed_amounts';

export interface TransformView {
  /** Right, up and towards the viewer, unit vectors in the world. */
  basis: Basis;
  jacobian: ScreenJacobian;
  /** The pivot's place, in pixels. */
  pivot: [number, number];
  /** The axes of X, Y and Z. `secondAxes` are those of a second press. */
  axes: Basis;
  secondAxes: Basis;
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
const BALL_RADIUS = 100; // pixels; a trackball turns by the angle whose arc is the pointer's travel

export class TransformSession {
  constraint: Constraint | undefined;
  /** Whether a rotation is a trackball: it rolls with the pointer about both directions of the screen. */
  trackball = false;
  readonly typed = new TypedAmounts();
  private readonly travel: PointerTravel;
  private modifiers: Modifiers = { shift: false, ctrl: false };

  constructor(public kind: MotionKind, private readonly view: TransformView, pointer: [number, number]) {
    this.travel = new PointerTravel(view.pivot, pointer);
    this.countAmounts();
  }

  /** Follows the pointer to a place in pixels. */
  pointer(x: number, y: number, modifiers: Modifiers): void {
    this.travel.to(x, y, modifiers.shift ? FINE : 1);
    this.modifiers = modifiers;
  }

  /** Continues from another place without a move. */
  resume(x: number, y: number): void {
    this.travel.resume(x, y);
  }

  /** Takes a key by its KeyboardEvent.key; undefined if it means nothing here. */
  key(key: string, shift: boolean): Outcome | undefined {
    if (key === 'Enter') return 'confirmed';
    if (key === 'Escape') return 'cancelled';
    if (!this.choice(key.toLowerCase(), shift) && !this.typed.key(key, shift)) return undefined;
    this.countAmounts();
    return 'running';
  }

  /** The motion of the transform as it is now. */
  motion(): Motion {
    const basis = this.constraint?.second ? this.view.secondAxes : this.view.axes;
    switch (this.kind) {
      case 'move':
        return { kind: 'move', offset: this.offset(basis) };
      case 'rotate':
        return this.trackball ? this.roll() : { kind: 'rotate', axis: this.axis(basis), angle: this.angle(basis) };
      case 'scale':
        return { kind: 'scale', basis, factors: this.factors() };
    }
  }

  /** A letter that chooses an axis, or another kind of transform. */
  private choice(letter: string, shift: boolean): boolean {
    const axis = letter.length === 1 ? AXIS_KEYS.indexOf(letter) : -1;
    const kind = KIND_KEYS[letter];
    if (axis >= 0) {
      this.constraint = nextConstraint(this.constraint, axis as Axis, shift);
      this.trackball = false;
    } else if (kind !== undefined) {
      this.trackball = kind === 'rotate' && this.kind === 'rotate' && !this.trackball;
      if (this.trackball) this.constraint = undefined;
      this.kind = kind;
    }
    return axis >= 0 || kind !== undefined;
  }

  private countAmounts(): void {
    if (this.kind === 'rotate') this.typed.count = this.trackball ? 2 : 1;
    else this.typed.count = freeAxes(this.constraint).length;
  }

  private offset(basis: Basis): Vec3 {
    const axes = freeAxes(this.constraint);
    const [dx, dy] = this.travel.way;
    const x: MutableVec3 = [0, 0, 0];
    if (!this.typed.isEmpty) {
      // Without a constraint the first number is along X, as in Blender.
      const { numbers } = this.typed.values(0);
      axes.forEach((axis, i) => (x[axis] = numbers[i]));
      return combine(basis, x);
    }
    const { jacobian, snapStep, basis: screen } = this.view;
    if (axes.length === 3) {
      const offset = combine(screen, [...amountsInPlane(jacobian, screen[0], screen[1], dx, dy), 0]);
      return offset.map((part) => this.snapped(part, snapStep)) as unknown as Vec3;
    }
    const [a, b] = axes.map((axis) => basis[axis]);
    const amounts = axes.length === 1 ? [amountAlong(jacobian, a, dx, dy)] : amountsInPlane(jacobian, a, b, dx, dy);
    axes.forEach((axis, i) => (x[axis] = this.snapped(amounts[i], snapStep)));
    return combine(basis, x);
  }

  /** Without a constraint, turns are about the line of sight; in a plane, about its normal. */
  private axis(basis: Basis): Vec3 {
    return this.constraint === undefined ? this.view.basis[2] : basis[this.constraint.axis];
  }

  private angle(basis: Basis): number {
    if (!this.typed.isEmpty) return radians(this.typed.values(0).numbers[0]);
    // The pointer turns about the line of sight. An axis that points away turns the other way round.
    const towards = dot(this.axis(basis), this.view.basis[2]) >= 0 ? 1 : -1;
    return towards * this.snapped(this.travel.turn, SNAP_ANGLE);
  }

  /**
   * Turns like a ball under the pointer: about up by the way right, about right by the way down. It is one turn about
   * the sum of both, as in Blender: the way back undoes it, and a part of more than half a turn can be applied.
   */
  private roll(): Motion {
    const [right, up] = this.view.basis;
    const [dx, dy] = this.travel.way;
    const [aboutRight, aboutUp] = this.typed.isEmpty
      ? [dy, dx].map((pixels) => this.snapped(pixels / BALL_RADIUS, SNAP_ANGLE))
      : this.typed.values(0).numbers.map(radians);
    const turn = add(scale(right, aboutRight), scale(up, aboutUp));
    return { kind: 'rotate', axis: normalized(turn), angle: length(turn) };
  }

  private factors(): Vec3 {
    const factors: MutableVec3 = [1, 1, 1];
    const { numbers, alone } = this.typed.values(1);
    const pointed = this.snapped(this.travel.factor, SNAP_FACTOR);
    freeAxes(this.constraint).forEach((axis, i) => {
      factors[axis] = this.typed.isEmpty ? pointed : numbers[alone ? 0 : i];
    });
    return factors;
  }

  private snapped(amount: number, step: number): number {
    if (!this.modifiers.ctrl) return amount;
    const size = this.modifiers.shift ? step * FINE : step;
    return Math.round(amount / size) * size;
  }
}

function radians(degrees: number): number {
  return (degrees * Math.PI) / 180;
}

/** The smallest step of 1, 2 or 5 times a power of ten that is at least `pixels` wide. */
export function snapStep(pixelsPerUnit: number, pixels = 24): number {
  const wanted = pixels / pixelsPerUnit;
  const power = 10 ** Math.floor(Math.log10(wanted));
  return power * ([1, 2, 5, 10].find((m) => m * power >= wanted) ?? 10);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A motion: a move, a turn or a scaling about any pivot. Soft selection applies a fraction of it.
//
// Layout  matrices are 4 x 4, column-major, and act on column vectors, as on the wire

import {
  add,
  combine,
  coordinates,
  cross,
  dot,
  scale,
  sub,
  type Basis,
  type MutableVec3,
  type Vec3,
} from '../lattice/vec';

export type Motion =
  | { kind: 'move'; offset: Vec3 }
  /** By `angle` radians, counter-clockwise seen from the tip of the unit vector `axis`. */
  | { kind: 'rotate'; axis: Vec3; angle: number }
  /** By one factor along each vector of `basis`. */
  | { kind: 'scale'; basis: Basis; factors: Vec3 };

export type MotionKind = Motion['kind'];

/** Where `p` goes under the fraction `weight` of a motion about `pivot`: 0 leaves it, 1 is the whole motion. */
export function moved(motion: Motion, pivot: Vec3, p: Vec3, weight = 1): Vec3 {
  switch (motion.kind) {
    case 'move':
      return add(p, scale(motion.offset, weight));
    case 'rotate':
      return add(pivot, rotated(motion.axis, motion.angle * weight, sub(p, pivot)));
    case 'scale': {
      const x = coordinates(motion.basis, sub(p, pivot));
      const factors = motion.factors.map((f) => 1 + (f - 1) * weight);
      return add(pivot, combine(motion.basis, [x[0] * factors[0], x[1] * factors[1], x[2] * factors[2]]));
    }
  }
}

/** Rodrigues' formula. */
export function rotated(axis: Vec3, angle: number, v: Vec3): Vec3 {
  const cos = Math.cos(angle);
  const along = scale(axis, dot(axis, v) * (1 - cos));
  return add(add(scale(v, cos), scale(cross(axis, v), Math.sin(angle))), along);
}

/** The motion about `pivot` as one matrix. */
export function motionMatrix(motion: Motion, pivot: Vec3): Float64Array {
  const origin = moved(motion, pivot, [0, 0, 0]);
  const matrix = new Float64Array(16);
  for (let column = 0; column < 3; ++column) {
    const unit: MutableVec3 = [0, 0, 0];
    unit[column] = 1;
    matrix.set(sub(moved(motion, pivot, unit), origin), 4 * column);
  }
  matrix.set([...origin, 1], 12);
  return matrix;
}

/** Whether a motion leaves everything where it is. */
export function isStill(motion: Motion): boolean {
  switch (motion.kind) {
    case 'move':
      return motion.offset.every((x) => x === 0);
    case 'rotate':
      return motion.angle === 0;
    case 'scale':
      return motion.factors.every((f) => f === 1);
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Vectors of three doubles. All functions are pure. three's classes are used for drawing only.

import type { Vec3 } from './lattice';

export type { Vec3 };

/** A Vec3 that can be written. */
export type MutableVec3 = [number, number, number];

/** Three unit vectors, or any three that span space: the columns of a matrix. */
export type Basis = readonly [Vec3, Vec3, Vec3];

export const WORLD_BASIS: Basis = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Vec3, s: number): Vec3 => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);
export const distance = (a: Vec3, b: Vec3): number => length(sub(a, b));

export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/** The unit vector along `a`; the zero vector stays zero. */
export function normalized(a: Vec3): Vec3 {
  const norm = length(a);
  return norm > 0 ? scale(a, 1 / norm) : [0, 0, 0];
}

/** x * basis[0] + y * basis[1] + z * basis[2]. */
export function combine(basis: Basis, x: Vec3): Vec3 {
  return add(add(scale(basis[0], x[0]), scale(basis[1], x[1])), scale(basis[2], x[2]));
}

/** The coordinates x with combine(basis, x) = v. The basis need not be orthogonal, but must span space. */
export function coordinates(basis: Basis, v: Vec3): Vec3 {
  const [a, b, c] = basis;
  const determinant = dot(a, cross(b, c));
  return [dot(v, cross(b, c)) / determinant, dot(v, cross(c, a)) / determinant, dot(v, cross(a, b)) / determinant];
}

/** Point `index` of a flat array of x y z. */
export function pointAt(points: ArrayLike<number>, index: number): Vec3 {
  return [points[3 * index], points[3 * index + 1], points[3 * index + 2]];
}

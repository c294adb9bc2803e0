// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tolerances that a grid of positions allows: view.proto, ViewOptions.tolerance. The server refuses others.

const POINT_ACCURACY = 3e-7; // of the grid's range
const MOST_BITS = 16;

/** Points are off by this much at most, for float32 and rounding: sqrt(3) (3e-7 range + step / 2). */
function pointError(range: number, bits: number): number {
  return Math.sqrt(3) * range * (POINT_ACCURACY + 0.5 / (2 ** bits - 1));
}

/** Whether positions of so many bits meet a tolerance: two thirds of it are left for them at most. */
export function meetsTolerance(tolerance: number, range: number, bits: number): boolean {
  return 3 * pointError(range, bits) <= 2 * tolerance;
}

/** The least tolerance that any bits meet. */
export function leastTolerance(range: number): number {
  return 1.5 * pointError(range, MOST_BITS);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { AXES } from '../lattice/grid';

/** Pairs of axes, in the order of numbers of a pair. */
export const PAIRS = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]] as const;

/**
 * Bounds of the second derivatives of a polynomial in l_0, l_1, l_2 from -1/2 to 1/2: of each coordinate, by each pair of axes.
 * A bound is the sum of the derivative's coefficients without their signs, times 1/2 for each factor l that is left.
 *
 * @param numbers x y z w of each coefficient (box_polynomials.ts), which begin at `first`.
 * @param terms Powers on each axis, 0 included.
 * @param out Six numbers for x, in the order of PAIRS, then those of y and z.
 */
export function boundSecondDerivatives(
  numbers: Float32Array, first: number, terms: readonly [number, number, number], out: Float64Array,
): void {
  out.fill(0);
  for (let n = 0; n < terms[0] * terms[1] * terms[2]; ++n) {
    const powers = [n % terms[0], Math.floor(n / terms[0]) % terms[1], Math.floor(n / (terms[0] * terms[1]))] as const;
    const least = 0.5 ** (powers[0] + powers[1] + powers[2] - 2);
    PAIRS.forEach(([a, b], pair) => {
      const factor = (a === b ? powers[a] * (powers[a] - 1) : powers[a] * powers[b]) * least;
      if (factor === 0) return;
      for (const axis of AXES) out[6 * axis + pair]! += factor * Math.abs(numbers[first + 4 * n + axis]!);
    });
  }
}

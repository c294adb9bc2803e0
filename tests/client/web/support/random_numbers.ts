// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Numbers that are the same in every run with the same seed: a linear congruential generator (Numerical Recipes). */
export class RandomNumbers {
  constructor(private state: number) {
    for (let i = 0; i < 8; ++i) this.next(); // small seeds begin alike
  }

  /** From 0 to less than 1. */
  next(): number {
    this.state = (Math.imul(this.state, 1_664_525) + 1_013_904_223) >>> 0;
    return this.state / 2 ** 32;
  }

  /** An integer from 0 to less than `end`. */
  below(end: number): number {
    return Math.floor(end * this.next());
  }
}

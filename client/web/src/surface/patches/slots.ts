// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Parts of an array, one behind the other, each with some room behind what is used of it. */
export class Slots {
  private readonly first: Uint32Array; // and the end of the last one
  private readonly counts: Uint32Array;

  /**
   * @param needs What is used of each slot.
   * @param share The room of a slot, of what is used of it.
   * @param unit The room is a multiple of this number.
   */
  constructor(readonly begin: number, needs: Uint32Array, share: number, unit = 1) {
    this.counts = needs.slice();
    this.first = new Uint32Array(needs.length + 1);
    let at = begin;
    needs.forEach((need, slot) => {
      this.first[slot] = at;
      at += need + unit * Math.ceil((share * need) / unit);
    });
    this.first[needs.length] = at;
  }

  get end(): number {
    return this.first.at(-1)!;
  }

  /** What is used of all slots. */
  get used(): number {
    return this.counts.reduce((sum, count) => sum + count, 0);
  }

  firstOf(slot: number): number {
    return this.first[slot]!;
  }

  usedOf(slot: number): number {
    return this.counts[slot]!;
  }

  /** The length of a slot. */
  roomOf(slot: number): number {
    return this.first[slot + 1]! - this.first[slot]!;
  }

  /** Uses this much of a slot, at most its room. */
  use(slot: number, count: number): void {
    this.counts[slot] = count;
  }
}

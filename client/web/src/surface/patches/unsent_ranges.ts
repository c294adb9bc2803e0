// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { BufferAttribute, InterleavedBuffer } from 'three';

/**
 * The parts of an attribute that are written but have not reached the GPU, which the next frame sends. A hidden page draws no
 * frame, so ranges are kept by their begin and do not pile up.
 */
export class UnsentRanges {
  private readonly ranges = new Map<number, { count: number }>();
  private isAll = false;

  constructor(private readonly attribute: BufferAttribute | InterleavedBuffer) {
    attribute.onUpload(() => {
      this.forget();
      this.isAll = false;
    });
  }

  add(start: number, count: number): void {
    if (count === 0) return;
    this.attribute.needsUpdate = true;
    if (this.isAll) return;
    const known = this.ranges.get(start);
    if (known) {
      known.count = Math.max(known.count, count); // of another layout, something else may begin at the same place
      return;
    }
    this.attribute.addUpdateRange(start, count);
    this.ranges.set(start, this.attribute.updateRanges.at(-1)!);
  }

  /** All of the attribute is written. */
  addAll(): void {
    this.forget(); // without ranges, three sends everything
    this.isAll = true;
    this.attribute.needsUpdate = true;
  }

  /** Three keeps ranges after the first upload, which sends everything. */
  private forget(): void {
    this.ranges.clear();
    this.attribute.clearUpdateRanges();
  }
}

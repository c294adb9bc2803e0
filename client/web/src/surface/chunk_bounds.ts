// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Box3, Vector3 } from 'three';

/** The box around the points of each chunk, in the numbers of the vertex buffer. */
export class ChunkBounds {
  private extents = new Float32Array();

  /** Forgets all boxes. */
  reset(chunks: number): void {
    this.extents = new Float32Array(6 * chunks).fill(NaN); // NaN: that chunk has not come
  }

  /** @param extent min x y z, max x y z */
  set(chunk: number, extent: Float32Array): void {
    this.extents.set(extent, 6 * chunk);
  }

  /** The box around all chunks; empty if there are none. */
  all(): Box3 {
    const all = new Box3();
    this.each((box) => void all.union(box));
    return all;
  }

  /** Calls `visit` with the box of each chunk, which it may change but not keep. */
  each(visit: (box: Box3) => void): void {
    const box = new Box3(new Vector3(), new Vector3());
    for (let i = 0; i < this.extents.length; i += 6) {
      if (!Number.isFinite(this.extents[i])) continue;
      box.min.fromArray(this.extents, i);
      box.max.fromArray(this.extents, i + 3);
      visit(box);
    }
  }
}

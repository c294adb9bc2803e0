// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { indexOf, type Axes } from '../lattice/grid';
import type { Seams } from './plan/patch_plan';

/** Which seams are attached: those whose control points are all at their identity points (patches.proto, Seams). */
export class SeamStates {
  readonly isAttached: Uint8Array;
  private readonly members: readonly Uint32Array[];

  constructor(private readonly seams: Seams, size: Axes) {
    const { ranges, identityPoints } = seams;
    this.isAttached = new Uint8Array(ranges.length / 6);
    this.members = Array.from(this.isAttached, (_, seam) => pointsIn(ranges.subarray(6 * seam, 6 * seam + 6), size));
    const most = this.members.reduce((sum, list) => Math.max(sum, list.at(-1) ?? 0), -1);
    if (3 * most + 2 >= identityPoints.length && most >= 0) throw new Error('The patch plan lacks identity points of its seams.');
  }

  /** Asks all control points again. Returns whether a seam was attached or torn. */
  update(points: Float64Array): boolean {
    let hasChanged = false;
    this.members.forEach((members, seam) => {
      const isAttached = Number(members.every((index) => this.isAtRest(points, index)));
      hasChanged ||= isAttached !== this.isAttached[seam];
      this.isAttached[seam] = isAttached;
    });
    return hasChanged;
  }

  private isAtRest(points: Float64Array, index: number): boolean {
    const { identityPoints } = this.seams;
    for (let at = 3 * index; at < 3 * index + 3; ++at) if (points[at] !== identityPoints[at]) return false;
    return true;
  }
}

function pointsIn([i0, i1, j0, j1, k0, k1]: ArrayLike<number> & Iterable<number>, size: Axes): Uint32Array {
  const points: number[] = [];
  for (let k = k0!; k <= k1!; ++k) for (let j = j0!; j <= j1!; ++j) for (let i = i0!; i <= i1!; ++i) points.push(indexOf(size, [i, j, k]));
  return Uint32Array.from(points);
}

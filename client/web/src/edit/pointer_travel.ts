// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The pointer's travel since a transform began: along the screen, around the pivot and away from it. Each part counts
// at the speed of its moment, so pressing Shift for fine control moves nothing by itself.

type Pixels = readonly [number, number];

const LEAST_RADIUS = 20; // pixels; a scaling that begins at the pivot would jump

export class PointerTravel {
  /** Pixels right and down. */
  readonly way: [number, number] = [0, 0];
  /** Radians around the pivot, counter-clockwise. */
  turn = 0;
  /** Distance from the pivot, divided by the distance at the begin. */
  factor = 1;
  private readonly startRadius: number;

  constructor(private readonly pivot: Pixels, private at: Pixels) {
    this.startRadius = Math.max(Math.hypot(at[0] - pivot[0], at[1] - pivot[1]), LEAST_RADIUS);
  }

  /** Follows the pointer; a `speed` below 1 is fine control. */
  to(x: number, y: number, speed: number): void {
    const [px, py] = this.pivot;
    const before = [this.at[0] - px, this.at[1] - py] as const;
    const after = [x - px, y - py] as const;
    this.way[0] += (after[0] - before[0]) * speed;
    this.way[1] += (after[1] - before[1]) * speed;
    this.turn += signedAngle(before, after) * speed;
    this.factor += ((Math.hypot(...after) - Math.hypot(...before)) / this.startRadius) * speed;
    this.at = [x, y];
  }

  /** Continues from another place, as a finger does that comes down again. */
  resume(x: number, y: number): void {
    this.at = [x, y];
  }
}

/** Counter-clockwise on a screen whose y points down. */
function signedAngle(from: Pixels, to: Pixels): number {
  return -Math.atan2(from[0] * to[1] - from[1] * to[0], from[0] * to[0] + from[1] * to[1]);
}

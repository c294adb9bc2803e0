// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Direct manipulation: a person holds one point of the surface, and the server finds the smallest move of control
// points that brings it to its target. Outside the lattice none does. Then the server tells the distance left.
import { distance, type Vec3 } from '../lattice/vec';
import type { SurfacePoint } from '../session/edits/lattice_edit';
import type { LiveSession } from '../session/live_session';
import type { Gesture } from '../session/scene_session';

const ROUNDING = 1e-6; // of the drag's length; edit.proto promises 1e-9 for a point that reaches its target

export class SurfacePull {
  private gesture: Gesture | undefined;
  private wanted: Vec3;
  private farthest = 0;
  private left = 0;

  /**
   * @param onAnswer Called when outOfReach may have changed.
   * @param onEnded Called when the session has ended the pull.
   */
  constructor(
    private readonly session: Pick<LiveSession, 'gesture'>,
    readonly point: SurfacePoint,
    private readonly onAnswer: () => void = () => {},
    private readonly onEnded: () => void = () => {},
  ) {
    this.wanted = point.position;
  }

  get target(): Vec3 {
    return this.wanted;
  }

  /** How far the point stays from its target, by the server's newest answer; 0 if it reaches the target. */
  get outOfReach(): number {
    return this.left > ROUNDING * this.farthest ? this.left : 0;
  }

  /** Moves the held point to `target`. */
  update(target: Vec3): void {
    this.gesture ??= this.session.gesture({
      dragged: (left) => {
        this.left = left;
        this.onAnswer();
      },
      ended: () => this.onEnded(),
    });
    this.wanted = target;
    this.farthest = Math.max(this.farthest, distance(this.point.position, target));
    this.gesture.update({ kind: 'drag', points: [this.point], targets: Float64Array.from(target) });
  }

  commit(): void {
    this.gesture?.commit();
  }

  cancel(): void {
    this.gesture?.cancel();
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Direct manipulation: a person holds one point of the surface, and the server finds the smallest move of control points
// that takes it along. Outside the lattice no control point moves it; the server then says how far it stays behind.
import { distance, type Vec3 } from '../lattice/vec';
import type { SurfacePoint } from '../session/edits/lattice_edit';
import type { LiveSession } from '../session/live_session';
import type { Gesture } from '../session/scene_session';

const ROUNDING = 1e-6; // of the way: a thousand times what a point that is taken along is away (edit.proto)

export class SurfacePull {
  private gesture: Gesture | undefined;
  private wanted: Vec3;
  private farthest = 0;
  private left = 0;

  /**
   * @param onAnswer Told when outOfReach may be another.
   * @param onEnded Told when the session has ended the pull.
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

  /** How far the point stays from its target, by the server's newest answer; 0 where it comes along. */
  get outOfReach(): number {
    return this.left > ROUNDING * this.farthest ? this.left : 0;
  }

  /** Takes the point held to `target`. */
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

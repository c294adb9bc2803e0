// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A gesture of the session that a motion drives. It begins on the server with the first change, so a press and release
// without a change is no undo step.
import type { Vec3 } from '../lattice/vec';
import type { LiveSession } from '../session/live_session';
import type { Gesture } from '../session/scene_session';
import { buildEdit, type Spread } from './build_edit';
import { isStill, type Motion } from './motion';

export class TransformGesture {
  private gesture: Gesture | undefined;
  private motion: Motion | undefined;
  private ended = false;

  constructor(
    private readonly session: Pick<LiveSession, 'gesture'>,
    private spread: Spread,
    readonly center: Vec3,
    private readonly onEnded: () => void = () => {},
  ) {}

  /** Whether it was not committed, cancelled or ended by the session. */
  get isRunning(): boolean {
    return !this.ended;
  }

  update(motion: Motion): void {
    if (this.ended) return;
    this.motion = motion;
    if (this.gesture === undefined && isStill(motion)) return;
    this.gesture ??= this.session.gesture({ ended: () => this.letGo() });
    this.gesture.update(buildEdit(this.spread, motion, this.center));
  }

  /** Changes which points move along. They move from their positions at the begin. */
  respread(change: (spread: Spread) => Spread): void {
    this.spread = change(this.spread);
    if (this.motion !== undefined) this.update(this.motion);
  }

  commit(): void {
    this.ended = true;
    this.gesture?.commit();
    this.gesture = undefined;
  }

  cancel(): void {
    this.ended = true;
    this.gesture?.cancel();
    this.gesture = undefined;
  }

  private letGo(): void {
    this.ended = true;
    this.gesture = undefined;
    this.onEnded();
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A gesture of the session that a motion drives. It begins on the server with the first change, so that a press and
// release without one is no undo step.
import type { Vec3 } from '../lattice/vec';
import type { Gesture, SceneSession } from '../session/scene_session';
import { buildEdit, type Spread } from './build_edit';
import { isStill, type Motion } from './motion';

export class TransformGesture {
  private gesture: Gesture | undefined;

  constructor(
    private readonly session: Pick<SceneSession, 'gesture'>,
    readonly spread: Spread,
    readonly center: Vec3,
  ) {}

  update(motion: Motion): void {
    if (this.gesture === undefined && isStill(motion)) return;
    this.gesture ??= this.session.gesture();
    this.gesture.update(buildEdit(this.spread, motion, this.center));
  }

  commit(): void {
    this.gesture?.commit();
    this.gesture = undefined;
  }

  cancel(): void {
    this.gesture?.cancel();
    this.gesture = undefined;
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Direct manipulation: one point of the surface is held, and the server finds the smallest move of control points that
// takes it along.
import type { Vec3 } from '../lattice/vec';
import type { SurfacePoint } from '../session/lattice_edit';
import type { Gesture, SceneSession } from '../session/scene_session';

export class SurfacePull {
  private gesture: Gesture | undefined;

  constructor(
    private readonly session: Pick<SceneSession, 'gesture'>,
    readonly point: SurfacePoint,
  ) {}

  /** Takes the point held to `target`. */
  update(target: Vec3): void {
    this.gesture ??= this.session.gesture();
    this.gesture.update({ kind: 'drag', points: [this.point], targets: Float64Array.from(target) });
  }

  commit(): void {
    this.gesture?.commit();
  }

  cancel(): void {
    this.gesture?.cancel();
  }
}

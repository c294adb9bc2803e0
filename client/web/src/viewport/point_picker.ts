// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the control point under the pointer, or those in a box, among the points that may be selected: not hidden and,
// unless selection goes through the surface, not behind it.
import type { Object3D } from 'three';
import type { Editor } from '../edit/editor';
import { pointAt } from '../lattice/vec';
import { Occlusion } from './occlusion';
import { nearestPoint, pointsInBox } from './projection';
import type { Viewport } from './viewport';

// In CSS pixels: where a press finds a point, and where it is on the point's disc, so that no handle gets it.
const REACH = { mouse: 11, pen: 14, touch: 24 } as Record<string, number>;
const DISC = { mouse: 6, pen: 7, touch: 10 } as Record<string, number>;

export class PointPicker {
  private visible: Uint8Array | undefined;
  private seenFrom = '';
  readonly occlusion: Occlusion;

  constructor(private readonly viewport: Viewport, private readonly editor: Editor) {
    this.occlusion = new Occlusion(viewport);
  }

  dispose(): void {
    this.occlusion.dispose();
  }

  /** The surface or the points have moved: forgets what the surface hides. */
  invalidate(): void {
    this.visible = undefined;
  }

  at(x: number, y: number, pointerType: string): number | undefined {
    const reach = REACH[pointerType] ?? REACH['mouse'];
    return nearestPoint(this.viewport.projectAll(this.editor.lattice.points), x, y, reach, this.eligible());
  }

  /** Whether a place is on the disc of a point. */
  isOnDisc(point: number, x: number, y: number, pointerType: string): boolean {
    const at = this.viewport.project(pointAt(this.editor.lattice.points, point));
    return at !== undefined && Math.hypot(at[0] - x, at[1] - y) <= (DISC[pointerType] ?? DISC['mouse']);
  }

  inBox(a: readonly [number, number], b: readonly [number, number]): number[] {
    return pointsInBox(this.viewport.projectAll(this.editor.lattice.points), a, b, this.eligible());
  }

  private eligible(): (index: number) => boolean {
    const { selection, session, settings } = this.editor;
    if (!settings.value.cage) return () => false;
    if (settings.value.through || !settings.value.surface) return (index) => !selection.isHidden(index);
    const visible = this.visiblePoints(session.surface.object);
    return (index) => !selection.isHidden(index) && visible[index] === 1;
  }

  /** Computed again only if the camera has moved, since the pointer asks at every move. */
  private visiblePoints(surface: Object3D): Uint8Array {
    const { camera } = this.viewport.rig;
    const from = [...camera.matrixWorld.elements, ...camera.projectionMatrix.elements].join();
    if (this.visible === undefined || from !== this.seenFrom) {
      this.visible = this.occlusion.visiblePoints(this.editor.lattice.points, surface);
      this.seenFrom = from;
    }
    return this.visible;
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which control point is under the pointer or in a box, among those that may be selected: not hidden and, unless
// selection goes through the surface, not behind it.
import type { Object3D } from 'three';
import type { Editor } from '../edit/editor';
import { Occlusion } from './occlusion';
import { nearestPoint, pointsInBox } from './projection';
import type { Viewport } from './viewport';

const REACH = { mouse: 11, pen: 14, touch: 24 } as Record<string, number>; // CSS pixels

export class PointPicker {
  private visible: Uint8Array | undefined;
  private seenFrom = '';
  private readonly occlusion: Occlusion;

  constructor(private readonly viewport: Viewport, private readonly editor: Editor) {
    this.occlusion = new Occlusion(viewport);
  }

  dispose(): void {
    this.occlusion.dispose();
  }

  /** Forgets what the surface hides: the surface or the points have moved. */
  invalidate(): void {
    this.visible = undefined;
  }

  at(x: number, y: number, pointerType: string): number | undefined {
    const reach = REACH[pointerType] ?? REACH['mouse'];
    return nearestPoint(this.viewport.projectAll(this.editor.lattice.points), x, y, reach, this.eligible());
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

  /** Found out anew only from another place: the pointer asks at every move. */
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

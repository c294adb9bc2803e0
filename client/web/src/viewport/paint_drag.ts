// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A stroke of the brush that paints vertex weights: visible vertices within the radius of the pointer's path go towards the
// brush's weight. The page shows them at once. The edit is sent when the stroke ends, so a stroke is one undo step.
import type { LiveSession } from '../session/live_session';
import type { Brush } from '../state/settings';
import type { PaintedVertices } from '../surface/painted_vertices';
import type { Drag, Place } from './drags';
import type { Occlusion } from './occlusion';
import type { Viewport } from './viewport';

const SPACING = 0.25; // of the radius, between two dabs on a path

export class PaintDrag implements Drag {
  private readonly painted: PaintedVertices;
  private readonly before: Float32Array;
  /** x, y, depth of each vertex in pixels. */
  private readonly screen: Float64Array;
  private readonly visible: Uint8Array;

  constructor(
    private readonly viewport: Viewport,
    private readonly session: LiveSession,
    private readonly brush: Brush,
    private at: Place,
    occlusion: Occlusion,
  ) {
    const { surface } = session;
    this.painted = surface.painted!;
    this.before = this.painted.weights.slice();
    const places = surface.vertexPlaces();
    this.screen = viewport.projectAll(places);
    this.visible = occlusion.visiblePoints(places.map((x) => (Number.isNaN(x) ? 0 : x)), surface.object);
    for (let v = 0; v < this.visible.length; ++v) if (Number.isNaN(places[3 * v]!)) this.visible[v] = 0;
    this.dab(...at);
    this.show();
  }

  move(x: number, y: number): void {
    const [fromX, fromY] = this.at;
    const length = Math.hypot(x - fromX, y - fromY), spacing = Math.max(SPACING * this.brush.radius, 1);
    const steps = Math.floor(length / spacing);
    if (steps === 0) return;
    for (let n = 1; n <= steps; ++n) {
      const share = (n * spacing) / length;
      this.dab(fromX + share * (x - fromX), fromY + share * (y - fromY));
    }
    const covered = (steps * spacing) / length;
    this.at = [fromX + covered * (x - fromX), fromY + covered * (y - fromY)];
    this.show();
  }

  end(): void {
    const { weights } = this.painted;
    const indices = Array.from(weights.keys()).filter((vertex) => weights[vertex] !== this.before[vertex]);
    if (indices.length > 0) this.session.setWeights(indices, Float32Array.from(indices, (vertex) => weights[vertex]!));
  }

  cancel(): void {
    this.painted.weights.set(this.before);
    this.show();
  }

  private dab(x: number, y: number): void {
    const { weights } = this.painted;
    const { radius, strength, weight } = this.brush;
    for (let vertex = 0; vertex < weights.length; ++vertex) {
      const away = Math.hypot(this.screen[3 * vertex]! - x, this.screen[3 * vertex + 1]! - y) / radius;
      if (!(away < 1) || this.visible[vertex] === 0) continue;
      const share = strength * (1 - away * away * (3 - 2 * away));
      weights[vertex] = Math.min(Math.max(weights[vertex]! + share * (weight - weights[vertex]!), 0), 1);
    }
  }

  private show(): void {
    this.painted.changed();
    this.viewport.invalidate();
  }
}

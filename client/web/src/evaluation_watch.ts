// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps a surface that the page evaluates by itself in step with the session's lattice, with the camera and with the settings.
// Before each frame that is drawn, what has changed is evaluated. No camera asks the server for anything.
import type { LiveSession } from './session/live_session';
import { PatchSurface, type Wanted } from './patches/patch_surface';
import { PlanCache } from './patches/plan/plan_cache';
import type { SettingsStore } from './state/settings';
import { seenTolerance } from './viewport/seen_tolerance';
import type { Viewport } from './viewport/viewport';

const PAUSE_MS = 150; // between two choices of levels while the camera moves, and after the last one
const POINTS_AT_REST = 2_000_000; // draw without effort on a laptop's GPU
const POINTS_WHILE_EDITING = 100_000;
const COARSER_WHILE_EDITING = 2;

export interface EvaluationEvents {
  /** The surface is another one. */
  changed(): void;
  /** Points of an edit that is so old have been evaluated, in ms. */
  evaluated(ms: number): void;
  /** The surface cannot be evaluated here. */
  failed(error: Error): void;
}

export class EvaluationWatch {
  private readonly surface: PatchSurface;
  private movedAt: number | undefined;
  private editedAt = -Infinity;
  private chosenAt = -Infinity;
  private seenBefore = '';
  private wasEditing = false;
  private wasLazy = false;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly ends: readonly (() => void)[];

  constructor(
    private readonly session: LiveSession,
    private readonly settings: SettingsStore,
    private readonly viewport: Viewport,
    private readonly events: EvaluationEvents,
  ) {
    const plans = new PlanCache(session.server, session.sceneId);
    this.surface = new PatchSurface(viewport.gl, () => viewport.renderer.resetState(), session.surface, {
      lattice: () => session.lattice,
      plan: (topologyId, normals) => plans.plan(topologyId, normals),
      ready: () => viewport.invalidate(),
      changed: () => events.changed(),
      failed: (error) => events.failed(error),
    });
    this.ends = [
      session.on('points', (indices) => this.moved(indices)),
      session.on('lattice', () => this.surface.latticeReplaced()),
      session.on('update', ({ revision }) => this.surface.updated(session.isAt(revision))),
      viewport.onDrawing(() => this.draw()),
    ];
    this.surface.updated(false); // what came before there was a view
    viewport.canvas.addEventListener('webglcontextrestored', this.restored);
  }

  /** Whether the page evaluates the surface. */
  get isActive(): boolean {
    return this.surface.isActive;
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.viewport.canvas.removeEventListener('webglcontextrestored', this.restored);
    for (const end of this.ends) end();
    this.surface.dispose();
  }

  /** What the GPU held is lost. */
  private readonly restored = (): void => {
    this.surface.dispose();
    this.viewport.invalidate();
  };

  private moved(indices: Uint32Array): void {
    this.surface.moved(indices);
    this.editedAt = performance.now();
    this.movedAt ??= this.editedAt;
  }

  private draw(): void {
    if (!this.isActive) return;
    const wanted = this.wanted();
    this.surface.draw(wanted);
    if (this.movedAt !== undefined) this.events.evaluated(performance.now() - this.movedAt);
    this.movedAt = undefined;
  }

  /** Also says when levels must be chosen anew. */
  private wanted(): Wanted {
    const now = performance.now();
    const isEditing = now - this.editedAt < PAUSE_MS;
    const { rig, pictureHeight } = this.viewport;
    const pixels = this.settings.value.pixels * (isEditing ? COARSER_WHILE_EDITING : 1);
    const seen = seenTolerance(rig.camera, pictureHeight, pixels);
    const key = JSON.stringify(seen);
    const isMoving = key !== this.seenBefore && isEditing === this.wasEditing;
    if (key !== this.seenBefore) {
      if (!isMoving || now - this.chosenAt >= PAUSE_MS) {
        this.surface.toleranceChanged();
        this.chosenAt = now;
        this.seenBefore = key;
        this.wasEditing = isEditing;
      }
    }
    if (!isMoving && this.wasLazy) this.surface.toleranceChanged(); // at rest, levels are those of the camera alone
    this.wasLazy = isMoving;
    if (isEditing || isMoving) this.lookLater();
    const most = this.mostWhileEditing;
    return { seen, isLazy: isMoving, mostPoints: isEditing ? most : Math.max(most, POINTS_AT_REST) };
  }

  private get mostWhileEditing(): number {
    return Math.max(POINTS_WHILE_EDITING, 6 * this.session.surface.patchCount);
  }

  private lookLater(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.viewport.invalidate(), PAUSE_MS + 10);
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps a surface that the page evaluates by itself in step with the session's lattice, with the camera and with the settings.
// Before each frame that is drawn, what has changed is evaluated. No camera asks the server for anything. The sum of several
// lattices comes with the server's updates, and the page adds what they have moved since.
import { sameStructure } from './lattice/grid';
import type { Lattice } from './lattice/lattice';
import type { LiveSession } from './session/live_session';
import type { UpdateInfo } from './session/scene_session';
import { SumAhead } from './session/sum_ahead';
import { movedPoints } from './session/summed_lattice';
import type { SeenTolerance } from './patches/levels/chosen_levels';
import { LevelPace, PAUSE_MS } from './patches/levels/level_pace';
import { PatchSurface } from './patches/patch_surface';
import { PlanCache } from './patches/plan/plan_cache';
import type { SettingsStore } from './state/settings';
import { seenTolerance } from './viewport/seen_tolerance';
import type { Viewport } from './viewport/viewport';

const POINTS_AT_REST = 2_000_000; // draw without effort on a laptop's GPU
const POINTS_WHILE_EDITING = 100_000;
const COARSER_WHILE_EDITING = 2;

export interface EvaluationEvents {
  /** The surface is another one. */
  changed(): void;
  /** Points of this window's newest edit have been evaluated, which is so old, in ms. */
  evaluated(ms: number): void;
  /** The surface cannot be evaluated here. */
  failed(error: Error): void;
}

export class EvaluationWatch {
  private readonly plans: PlanCache;
  private readonly surface: PatchSurface;
  private readonly pace = new LevelPace();
  /** performance.now() of the newest edit, and of this window's newest one that no frame shows. */
  private editedAt = -Infinity;
  private ownEditAt: number | undefined;
  private readonly ahead = new SumAhead();
  private shownSum: Lattice | undefined; // that of the newest update, …
  private isAhead = false; // … or one that is ahead of it
  private isBehind = false; // lattices have moved since the last frame,
  private ownMoveAt: number | undefined; // and this window moved them then
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly ends: readonly (() => void)[];

  constructor(
    private readonly session: LiveSession,
    private readonly settings: SettingsStore,
    private readonly viewport: Viewport,
    private readonly events: EvaluationEvents,
  ) {
    this.plans = new PlanCache(session.server, session.sceneId);
    this.surface = new PatchSurface(viewport.gl, () => viewport.renderer.resetState(), session.surface, {
      lattice: () => this.shownSum ?? this.sum ?? session.lattice,
      plan: (topologyId, normals) => this.plans.plan(topologyId, normals),
      ready: () => viewport.invalidate(),
      changed: () => events.changed(),
      failed: (error) => events.failed(error),
    });
    this.ends = [
      session.on('points', (indices, isOwn) => this.moved(indices, isOwn)),
      session.on('lattice', () => (this.sum ? this.goAhead() : this.surface.latticeReplaced())),
      session.on('update', (update) => this.updated(update)),
      viewport.onDrawing(() => this.draw()),
    ];
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
    this.plans.close();
    this.surface.dispose();
  }

  /** What the GPU held is lost. */
  private readonly restored = (): void => {
    this.surface.dispose();
    this.viewport.invalidate();
  };

  private get sum(): Lattice | undefined {
    return this.session.surface.edgeBounds.sum;
  }

  private moved(indices: Uint32Array, isOwn: boolean): void {
    this.editedAt = performance.now();
    if (this.sum) {
      this.isBehind = true;
      if (isOwn) this.ownMoveAt = this.editedAt;
      return this.viewport.invalidate();
    }
    this.surface.moved(indices);
    if (isOwn) this.ownEditAt = this.editedAt;
  }

  /** Once per frame: each pointer event may move lattices. */
  private catchUp(): void {
    this.isBehind = false;
    if (this.goAhead()) this.ownEditAt = this.ownMoveAt ?? this.ownEditAt; // or else it is seen with its update
    this.ownMoveAt = undefined;
  }

  private updated({ revision, msFromEdit }: UpdateInfo): void {
    const { session, sum, isAhead } = this;
    const isInStep = sum ? session.areAllAt(revision) : session.isAt(revision);
    if (!sum) this.ahead.forget();
    else if (isInStep) this.ahead.take(sum, session.numberedLattices);
    if (!sum || isInStep || !this.goAhead()) this.show(sum);
    this.surface.updated(sum ? !this.isAhead : isInStep);
    if (sum && !isAhead && msFromEdit !== undefined) this.ownEditAt = performance.now() - msFromEdit;
  }

  /** Shows the sum of the lattices as the page has them. Returns whether it is known. */
  private goAhead(): boolean {
    const sum = this.ahead.of(this.session.numberedLattices);
    if (sum) this.show(sum);
    return sum !== undefined;
  }

  private show(sum: Lattice | undefined): void {
    const before = this.shownSum;
    this.shownSum = sum;
    this.isAhead = sum !== this.sum;
    if (sum === before) return;
    if (sum && before && sameStructure(sum, before)) this.surface.moved(movedPoints(before, sum));
    else this.surface.latticeReplaced();
  }

  private draw(): void {
    if (!this.isActive || (!this.sum && !this.session.hasShownLattice)) return; // another lattice is about to be shown
    if (this.isBehind) this.catchUp();
    const now = performance.now();
    const isEditing = now - this.editedAt < PAUSE_MS;
    const seen = this.tolerance(isEditing);
    const { isDue, isLazy } = this.pace.frame(JSON.stringify(seen), isEditing, now);
    if (isDue) this.surface.toleranceChanged();
    if (isEditing || isLazy) this.lookLater();
    const most = this.mostWhileEditing;
    const isShown = this.surface.draw({ seen, isLazy, mostPoints: isEditing ? most : Math.max(most, POINTS_AT_REST) });
    if (!isShown || this.ownEditAt === undefined) return;
    this.events.evaluated(performance.now() - this.ownEditAt);
    this.ownEditAt = undefined;
  }

  private tolerance(isEditing: boolean): SeenTolerance {
    const { rig, pictureHeight } = this.viewport;
    return seenTolerance(rig.camera, pictureHeight, this.settings.value.pixels * (isEditing ? COARSER_WHILE_EDITING : 1));
  }

  private get mostWhileEditing(): number {
    return Math.max(POINTS_WHILE_EDITING, 6 * this.session.surface.patchCount);
  }

  private lookLater(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.viewport.invalidate(), PAUSE_MS + 10);
  }
}

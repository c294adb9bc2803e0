// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Code, ConnectError } from '@connectrpc/connect';
import type { NormalMode } from 'latticed/v1/view_pb';
import type { Lattice } from '../lattice/lattice';
import { sameStructure } from '../lattice/grid';
import { adaptivePattern } from '../surface/patches/adaptive_pattern';
import type { ChunkPatterns } from '../surface/patches/patch_places';
import { pointsIn } from '../surface/patches/patch_pattern';
import { EvaluatedPoints } from '../surface/evaluated_points';
import type { SurfaceMesh } from '../surface/surface_mesh';
import type { TopologyLayout } from '../surface/topology_layout';
import { ServerError } from '../wire/server_error';
import { ChunkExtents } from './chunk_extents';
import { ChosenLevels, type SeenTolerance } from './levels/chosen_levels';
import { CornerPositions } from './corner_positions';
import { patternCodes, UNKNOWN_BEND } from './levels/edge_levels';
import { PatchEvaluator } from './gpu/patch_evaluator';
import type { PatchPlan } from './plan/patch_plan';

const HALF_PLACE = 0.5 / 65_535;
const PLACE_ERROR = HALF_PLACE * Math.sqrt(3); // of the largest side: places have 16 bits on each axis
const FLOAT_ERROR = 1e-6; // of the diagonal (patches.proto, Positions)
const ASK_AGAIN_MS = 1000; // after a plan did not come; each time twice as long
const MOST_QUESTIONS = 6;

/** What is evaluated: a plan in a lattice of one structure. */
interface Stage {
  readonly plan: PatchPlan;
  readonly layout: TopologyLayout;
  readonly structure: Lattice;
  readonly evaluator: PatchEvaluator;
  readonly points: EvaluatedPoints;
  readonly corners: CornerPositions;
  readonly extents: ChunkExtents;
  readonly chosen: ChosenLevels;
  /** Of all edges. */
  readonly bytes: Uint8Array;
  /** Whether the page's lattice differs from that of the bytes. */
  isAhead: boolean;
  /** How far points may be from the surface, with the levels as they are and the lattice of the bytes; 0: not known. */
  error: number;
}

/** What a surface is evaluated from, and who wants to know of it. */
export interface EvaluationSource {
  /** The lattice that the page shows, or the sum of several, with own edits; another object once its structure has changed. */
  lattice(): Lattice;
  plan(topologyId: string, normals: NormalMode): Promise<PatchPlan>;
  /** A plan has come: a frame is due. */
  ready(): void;
  /** The surface is another one. */
  changed(): void;
  /** The surface cannot be evaluated here, in words. */
  failed(error: Error): void;
}

export interface Wanted {
  readonly seen: SeenTolerance;
  /** Whether levels that are finer than needed by one may stay. */
  readonly isLazy: boolean;
  /** Points at most; more make the tolerance four times as large, as often as needed. */
  readonly mostPoints: number;
}

/**
 * A surface that the page's GPU evaluates by itself (ENCODING_PATCHES), from the lattice that the page shows: own edits are seen
 * before the server answers. The server's updates bring bounds of edges, and with them other levels; of several lattices also
 * their sum.
 */
export class PatchSurface {
  private stage: Stage | undefined;
  private plan: PatchPlan | undefined;
  private planFor = '';
  private questions = 0; // for this plan
  private askAgain: ReturnType<typeof setTimeout> | undefined;
  private hasFailed = false;
  private isInStep = false;
  private hasMoved = false;
  private levelsAreOld = true;

  /** @param restore Called after calls to the GPU: what it has bound has changed. */
  constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly restore: () => void,
    private readonly surface: SurfaceMesh,
    private readonly source: EvaluationSource,
  ) {}

  /** Whether the surface is evaluated here. */
  get isActive(): boolean {
    return this.surface.edgeBounds.layout !== undefined;
  }

  /** Control points have moved. */
  moved(indices: Iterable<number>): void {
    this.isInStep = false;
    if (!this.stage) return;
    this.stage.evaluator.moved(indices);
    this.hasMoved = true;
    this.stage.isAhead = true;
  }

  /** The lattice is another one, perhaps of another structure. */
  latticeReplaced(): void {
    const { stage } = this;
    this.isInStep = false;
    if (!stage || !sameStructure(stage.structure, this.source.lattice())) return;
    stage.evaluator.moved();
    this.hasMoved = stage.isAhead = true;
  }

  /** An update has come. `isInStep`: the page shows the lattice of its revision. */
  updated(isInStep: boolean): void {
    this.levelsAreOld = true;
    this.isInStep = isInStep;
    if (this.stage && isInStep) this.stage.isAhead = false;
  }

  /** The tolerance has changed. */
  toleranceChanged(): void {
    this.levelsAreOld = true;
  }

  /** Called before a frame: evaluates what has changed. Returns whether the points are those of the page's lattice. */
  draw(wanted: Wanted): boolean {
    const { edgeBounds } = this.surface;
    if (!edgeBounds.isComplete || this.hasFailed || this.gl.isContextLost()) return false;
    if (this.planFor !== `${edgeBounds.layout!.id} ${edgeBounds.normals}`) this.ask();
    const { plan } = this;
    if (!plan || !this.isOfOneStructure) return false;
    const stage = this.stage?.plan === plan && sameStructure(this.stage.structure, this.source.lattice()) ? this.stage : undefined;
    if (stage && !this.hasMoved && !this.levelsAreOld && this.surface.draws(stage.points)) return true;
    try {
      this.evaluate(stage ?? this.staged(plan), wanted);
      return true;
    } catch (error) {
      this.fail(error as Error);
      return false;
    } finally {
      this.restore();
    }
  }

  /** Whether the bounds are of the structure of the page's lattice. If not, others will come. */
  private get isOfOneStructure(): boolean {
    const { structure } = this.surface.edgeBounds;
    return structure !== undefined && sameStructure(structure, this.source.lattice());
  }

  /** Frees what the GPU holds. The next frame begins anew. */
  dispose(): void {
    clearTimeout(this.askAgain);
    this.disposeStage();
    this.plan = undefined;
    this.planFor = '';
  }

  private fail(error: Error): void {
    this.dispose();
    this.hasFailed = true;
    this.source.failed(error);
  }

  private disposeStage(): void {
    if (this.stage && this.surface.draws(this.stage.points)) this.surface.hide();
    this.stage?.points.dispose();
    this.stage?.evaluator.dispose();
    this.stage = undefined;
  }

  private ask(): void {
    const { layout, normals } = this.surface.edgeBounds;
    const key = `${layout!.id} ${normals}`;
    clearTimeout(this.askAgain);
    this.planFor = key;
    this.plan = undefined;
    ++this.questions;
    this.source.plan(layout!.id, normals!).then((plan) => {
      if (this.planFor !== key) return;
      this.plan = plan;
      this.questions = 0;
      this.levelsAreOld = true;
      this.source.ready();
    }, (reason: unknown) => {
      if (this.planFor === key) this.missed(reason);
    });
  }

  /** Asks again later, unless another answer cannot be hoped for. */
  private missed(reason: unknown): void {
    const error = ServerError.fromConnect(reason);
    // Not found: the lattice has another structure by now, whose bounds will come, or this one again.
    const isPassing = reason instanceof ConnectError && (error.isPassing || error.code === Code.NotFound);
    if (!isPassing || this.questions >= MOST_QUESTIONS) return this.fail(reason as Error);
    this.askAgain = setTimeout(() => {
      this.planFor = '';
      this.source.ready();
    }, ASK_AGAIN_MS * 2 ** (this.questions - 1));
  }

  private evaluate(stage: Stage, wanted: Wanted): void {
    const { evaluator, points, corners } = stage;
    let chunks: readonly number[] | undefined = [];
    let moved: readonly number[] = [];
    const isErrorOld = this.hasMoved || this.levelsAreOld;
    if (this.hasMoved) {
      const lattice = this.source.lattice();
      const { boxes, seams } = evaluator.update(lattice.points, lattice.strength);
      moved = corners.update(boxes);
      stage.extents.update(boxes);
      chunks = seams ? undefined : moved;
      this.hasMoved = false;
    }
    if (this.levelsAreOld) {
      const repatterned = this.takeLevels(stage, wanted);
      chunks = chunks && repatterned && [...new Set([...chunks, ...repatterned])];
      this.levelsAreOld = false;
    }
    if (isErrorOld) stage.error = this.errorOf(stage);
    this.surface.certifiedError = stage.isAhead ? 0 : stage.error;
    const isFirst = !this.surface.draws(points); // also after a time with points from the server
    if (isFirst) chunks = undefined;
    if (chunks?.length === 0) return;
    const all = chunks === undefined ? [{ first: 0, count: points.places.room }] : points.rangesOf(chunks);
    for (const { first, count } of all) evaluator.evaluate(first, count);
    points.evaluated();
    const measured = chunks === undefined ? stage.layout.firstPatch.subarray(0, -1).keys() : moved;
    this.surface.applyEvaluation({
      points, normals: stage.plan.hasNormals, grid: { origin: stage.plan.origin, step: 1, range: 0, positionBits: 0, normalBits: 0 },
      extents: new Map(Array.from(measured, (chunk) => [chunk, stage.extents.of(chunk)])),
    });
    this.source.changed();
  }

  /** Begins to evaluate another plan. */
  private staged(plan: PatchPlan): Stage {
    const { surface } = this;
    const lattice = this.source.lattice();
    const layout = surface.edgeBounds.layout!;
    this.disposeStage();
    if (plan.patchCount !== layout.patchCount) throw new Error('The patch plan is of another surface.');
    const evaluator = new PatchEvaluator(this.gl, plan, lattice);
    const boxOf = (patch: number): number => evaluator.boxOf(patch);
    const corners = new CornerPositions(plan, layout, evaluator.boxes, boxOf);
    this.stage = {
      plan, layout, structure: lattice, evaluator, points: new EvaluatedPoints(layout, evaluator.buffers),
      corners, extents: new ChunkExtents(plan, layout, evaluator.boxes, corners, boxOf),
      chosen: new ChosenLevels(plan), bytes: new Uint8Array(plan.edgeCount).fill(UNKNOWN_BEND),
      isAhead: !this.isInStep, error: 0,
    };
    surface.edgeBounds.writeAllAgain();
    this.hasMoved = this.levelsAreOld = true;
    return this.stage;
  }

  /** Returns the chunks with other patterns, or undefined if all points lie elsewhere now. */
  private takeLevels(stage: Stage, { seen, isLazy, mostPoints }: Wanted): readonly number[] | undefined {
    const { plan, layout, chosen, bytes, corners, points } = stage;
    this.surface.edgeBounds.writeNew(bytes, plan.edgesBefore);
    chosen.choose(bytes, corners.positions, seen, isLazy);
    let codes = patternCodes(plan.edges, chosen.levels, 0, plan.patchCount);
    while (count(codes) > mostPoints && chosen.levels.some((level) => level > 0)) {
      chosen.levels.forEach((level, edge) => (chosen.levels[edge] = Math.max(level - 1, 0)));
      codes = patternCodes(plan.edges, chosen.levels, 0, plan.patchCount);
    }
    const patterns = Array.from({ length: layout.chunkCount }, (_, index): ChunkPatterns =>
      ({ index, codes: codes.subarray(layout.firstPatch[index], layout.firstPatch[index + 1]) }));
    return points.take(patterns);
  }

  private errorOf({ plan, chosen, bytes, corners }: Stage): number {
    const error = chosen.error(bytes);
    if (!Number.isFinite(error)) return 0;
    const { positions } = corners;
    const sides = [0, 1, 2].map((axis) => {
      let [low, high] = [Infinity, -Infinity];
      for (let at = axis; at < positions.length; at += 3) {
        low = Math.min(low, positions[at]!);
        high = Math.max(high, positions[at]!);
      }
      return high - low;
    });
    const weights = plan.weights ? HALF_PLACE * Math.hypot(...corners.largestMove()) : 0; // they have 16 bits, too
    return error + weights + PLACE_ERROR * Math.max(...sides) + FLOAT_ERROR * Math.hypot(...sides);
  }
}

const pointsOfCode = new Uint16Array(512);

function count(codes: Uint16Array): number {
  let points = 0;
  for (const code of codes) points += pointsOfCode[code] ||= pointsIn(adaptivePattern(code));
  return points;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates a random plan on the GPU and compares all points with the definition, and points that patches share with each other.
import { NormalMode } from 'latticed/v1/view_pb';
import type { Axes } from '@src/lattice/grid';
import type { Vec3 } from '@src/lattice/lattice';
import { PatchEvaluator } from '@src/patches/gpu/patch_evaluator';
import { ADAPTIVE_WHOLE } from '@src/surface/patches/adaptive_pattern';
import { patternCodes } from '@src/patches/levels/edge_levels';
import { PlanReader } from '@src/patches/plan/plan_reader';
import { adaptivePattern } from '@src/surface/patches/adaptive_pattern';
import { unpacked } from '@src/surface/patches/patch_pattern';
import { randomPlan } from './random_plan';
import { RandomNumbers } from './random_numbers';
import { referencePoint } from './reference_patches';

export interface Comparison {
  readonly points: number;
  /** Points that several patches have, counted once. */
  readonly shared: number;
  /** Those of them whose positions differ in a bit. */
  readonly differing: number;
  /** The same, of points that patches inside and outside the frame share. */
  readonly sharedOnSeam: number;
  readonly differingOnSeam: number;
  /** The largest distance from the definition, as a share of the diagonal of all points. */
  readonly worst: number;
  /** In radians. */
  readonly worstNormal: number;
}

/** @param isTorn Whether the seam's control points are moved too. */
export async function comparePatches(
  gl: WebGL2RenderingContext, seed: number, degree: Axes, mode: NormalMode, isTorn: boolean, isWeighted = false,
): Promise<Comparison> {
  const made = await randomPlan(seed, degree, mode, isWeighted);
  const plan = await PlanReader.read((async function* () { yield* made.parts; })());
  const random = new RandomNumbers(seed + 1000);
  const levels = Uint8Array.from({ length: plan.edgeCount }, () => random.below(4));
  const codes = patternCodes(plan.edges, levels, 0, plan.patchCount);
  const places = Uint32Array.from(Array.from(codes, (code, patch) => [...adaptivePattern(code).points].flatMap((entry) => [patch, entry])).flat());
  const evaluator = new PatchEvaluator(gl, plan, made.lattice);
  const count = places.length / 2;
  evaluator.buffers.reserve(count);
  evaluator.buffers.writePlaces(places, 0, count);
  evaluator.update(made.lattice.points);
  if (isTorn) {
    made.lattice.points[0] += 0.4; // of the only control point that moves: an update must find its boxes and its seam
    evaluator.moved([0]);
    evaluator.update(made.lattice.points);
  }
  const half = count >> 1; // in two parts, as after a change of a part
  evaluator.evaluate(0, half);
  evaluator.evaluate(half, count - half);
  const { positions, normals } = evaluator.buffers.read(count);
  evaluator.dispose();

  const shared = new Map<string, { first: string; times: number; differs: boolean; sides: Set<boolean> }>();
  const bits = new Uint32Array(positions.buffer);
  let [worst, worstNormal] = [0, 0];
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let n = 0; n < count; ++n) {
    const patch = places[2 * n];
    const [i1, i2] = unpacked(places[2 * n + 1]);
    const weights: Vec3 = [ADAPTIVE_WHOLE - i1 - i2, i1, i2];
    const expected = referencePoint(made, patch, weights, !isTorn);
    const position = [0, 1, 2].map((axis) => plan.origin[axis] + positions[3 * n + axis]);
    position.forEach((x, axis) => {
      low[axis] = Math.min(low[axis], x);
      high[axis] = Math.max(high[axis], x);
    });
    worst = Math.max(worst, Math.hypot(...position.map((x, axis) => x - expected.position[axis])));
    const normal = normals.subarray(3 * n, 3 * n + 3);
    if (plan.hasNormals) worstNormal = Math.max(worstNormal, angle(normal, expected.normal));
    const key = sharedKey(made.patches[patch].corners, weights);
    if (!key) continue;
    const own = `${bits[3 * n]} ${bits[3 * n + 1]} ${bits[3 * n + 2]}`;
    const entry = shared.get(key) ?? { first: own, times: 0, differs: false, sides: new Set() };
    ++entry.times;
    entry.differs ||= own !== entry.first;
    entry.sides.add(made.patches[patch].isOutside);
    shared.set(key, entry);
  }
  const all = [...shared.values()].filter(({ times }) => times > 1);
  const onSeam = all.filter(({ sides }) => sides.size === 2);
  return {
    points: count, shared: all.length, differing: all.filter(({ differs, sides }) => differs && sides.size === 1).length,
    sharedOnSeam: onSeam.length, differingOnSeam: onSeam.filter(({ differs }) => differs).length,
    worst: worst / Math.hypot(...high.map((x, axis) => x - low[axis])), worstNormal,
  };
}

/** Names a point of a vertex or an edge by its vertices and its place between them; undefined for others. */
function sharedKey(corners: readonly number[], weights: Vec3): string | undefined {
  const used = corners.map((corner, k) => ({ corner, weight: weights[k] })).filter(({ weight }) => weight > 0);
  if (used.length === 3) return undefined;
  return used.sort((a, b) => a.corner - b.corner).map(({ corner, weight }) => `${corner}:${weight}`).join(' ');
}

function angle(a: ArrayLike<number>, b: Vec3): number {
  const cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  return Math.atan2(Math.hypot(...cross), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

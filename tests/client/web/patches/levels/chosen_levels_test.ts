// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Levels of edges for a tolerance that depends on the distance from the eye, and the bounds that they follow from.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { OrthographicCamera, PerspectiveCamera, Vector3 } from 'three';
import { TopologySchema } from 'latticed/v1/event_pb';
import { NormalMode } from 'latticed/v1/view_pb';
import { ChosenLevels } from '@src/patches/levels/chosen_levels';
import { EdgeBounds } from '@src/patches/levels/edge_bounds';
import { bendOf } from '@src/patches/levels/edge_levels';
import type { PatchPlan } from '@src/patches/plan/patch_plan';
import { PlanReader } from '@src/patches/plan/plan_reader';
import { TopologyLayout } from '@src/surface/topology_layout';
import { seenTolerance } from '@src/viewport/seen_tolerance';
import { RandomNumbers } from '../../support/random_numbers';
import { randomPlan } from '../../support/random_plan';

async function samplePlan(): Promise<PatchPlan> {
  const { parts } = await randomPlan(3, [2, 2, 2], NormalMode.FACET);
  return { ...(await PlanReader.read((async function* () { yield* parts; })())), curvatureUnit: 2 ** -12 };
}

/** Random vertices, about [7, 8, 9] in the world, and a random bound for each edge. */
function randomState(plan: PatchPlan): { positions: Float64Array; bytes: Uint8Array } {
  const random = new RandomNumbers(7);
  const positions = Float64Array.from({ length: 3 * plan.vertexCount }, (_, at) => 7 + (at % 3) - plan.origin[at % 3] + random.next());
  return { positions, bytes: Uint8Array.from({ length: plan.edgeCount }, () => random.below(20)) };
}

test('an edge is as fine as the nearest of its patches needs, at any point of them, and no finer than the nearest point of all could', async () => {
  const plan = await samplePlan();
  const { positions, bytes } = randomState(plan);
  const eye = [7.5, 8.5, 14] as const;
  const chosen = new ChosenLevels(plan);

  chosen.choose(bytes, positions, { eye, perDistance: 1e-3, nearest: 0.1 }, false);

  const distanceOf = (vertex: number): number => Math.hypot(...[0, 1, 2].map((axis) => positions[3 * vertex + axis] + plan.origin[axis] - eye[axis]));
  for (let patch = 0; patch < plan.patchCount; ++patch) {
    const nearest = Math.min(...[0, 1, 2].map((k) => distanceOf(plan.corners[3 * patch + k])));
    for (const edge of plan.edges.subarray(3 * patch, 3 * patch + 3)) {
      const error = bendOf(bytes[edge], plan.curvatureUnit) / 6 / 4 ** chosen.levels[edge];
      assert.ok(error <= 1e-3 * nearest, `${error} at a distance of ${nearest}`);
    }
  }
  const error = chosen.error(bytes);
  assert.ok(error > 1e-3 && error < 6e-3, `${error}`); // 3.5 to 5.6 away, less the size of patches of up to 1.7
  assert.ok(new Set(chosen.levels).size > 1);
});

test('a level that is finer than needed by one stays while the camera moves; one that is too coarse never does', async () => {
  const plan = await samplePlan();
  const { positions, bytes } = randomState(plan);
  const chosen = new ChosenLevels(plan);
  const at = (everywhere: number, isLazy: boolean): number[] => {
    chosen.choose(bytes, positions, { everywhere }, isLazy);
    return [...chosen.levels];
  };
  const fine = at(1e-4, false);

  assert.deepEqual(at(3e-4, true), fine);
  const coarse = at(3e-4, false);
  assert.ok(coarse.some((level, edge) => level < fine[edge]));
  assert.deepEqual(at(1e-4, true), fine);
  assert.ok(at(0.1, true).every((level, edge) => level === (fine[edge] === 1 ? 1 : 0))); // 0 is enough
  bytes[0] = 255;
  assert.equal(at(1, false)[0], 5);
  assert.equal(chosen.error(bytes), Infinity);
});

test('a displacement by the tolerance moves no point of the picture by more than the pixels asked for', () => {
  const random = new RandomNumbers(9);
  const [width, height, pixels] = [900, 600, 0.5];
  const perspective = new PerspectiveCamera(40, width / height, 0.01, 100);
  perspective.position.set(1, 2, 6);
  perspective.lookAt(0.2, 0.1, 0);
  const orthographic = new OrthographicCamera(-3, 3, 2, -2, 0.1, 10);
  for (const camera of [perspective, orthographic]) {
    const seen = seenTolerance(camera, height, pixels);
    let worst = 0;
    for (let n = 0; n < 2000; ++n) {
      const point = new Vector3(2 * random.next() - 1, 2 * random.next() - 1, 0.5 * random.next()).unproject(camera);
      const tolerance = 'everywhere' in seen ? seen.everywhere : seen.perDistance * point.distanceTo(camera.position);
      const away = new Vector3(random.next() - 0.5, random.next() - 0.5, random.next() - 0.5).setLength(tolerance).add(point);
      const [from, to] = [point, away].map((p) => p.project(camera));
      worst = Math.max(worst, Math.hypot(((from.x - to.x) * width) / 2, ((from.y - to.y) * height) / 2));
    }
    assert.ok(worst <= 1.001 * pixels && worst > 0.8 * pixels, `${worst} pixels`);
  }
});

test('bounds are kept by edge; those that do not fit the patches or the plan are refused', () => {
  const layout = new TopologyLayout(create(TopologySchema, { topologyId: 'a', patchCount: 3n, chunkRuns: [{ chunkCount: 3, patchesPerChunk: 1 }] }));
  const bounds = new EdgeBounds();
  const before = Uint32Array.of(0, 3, 5, 7);
  const bytes = new Uint8Array(7);
  const take = (firstChunk: number, chunkCount: number, firstEdge: number, ...own: number[]): void =>
    bounds.take({ layout, normals: NormalMode.FACET, runs: [{ firstChunk, chunkCount, firstEdge, bytes: Uint8Array.from(own) }] });

  take(0, 2, 0, 1, 2, 3, 4, 5);
  assert.equal(bounds.isComplete, false);
  assert.throws(() => bounds.writeNew(bytes, before), /bounds of 5 edges in place of 7/);
  take(2, 1, 5, 6, 7);
  assert.equal(bounds.isComplete, true);
  assert.deepEqual(bounds.writeNew(bytes, before), [0, 1, 2]);
  assert.deepEqual([...bytes], [1, 2, 3, 4, 5, 6, 7]);
  take(1, 2, 3, 8, 9, 10, 11);
  assert.deepEqual(bounds.writeNew(bytes, before), [1, 2]);
  assert.deepEqual([...bytes], [1, 2, 3, 8, 9, 10, 11]);
  assert.deepEqual(bounds.writeNew(bytes, before), []);
  bounds.writeAllAgain();
  assert.deepEqual(bounds.writeNew(bytes, before), [0, 1, 2]);
  assert.throws(() => take(2, 1, 8, 1, 2), /bounds of 10 edges, but 3 patches/);
  bounds.clear();
  assert.equal(bounds.isComplete, false);
  assert.equal(bounds.layout, undefined);
});

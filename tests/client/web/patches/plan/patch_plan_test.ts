// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Patch plans as they come, levels of edges, and the polynomials of knot boxes. How points are evaluated: e2e/patches/patches_e2e_test.ts.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { PatchPlanPartSchema, type PatchPlanHeader, type PatchPlanPart, type PatchRun, type PatchSeams } from 'latticed/v1/patches_pb';
import { clone } from '@bufbuild/protobuf';
import { NormalMode } from 'latticed/v1/view_pb';
import { evaluate } from '@src/lattice/bspline';
import type { Vec3 } from '@src/lattice/lattice';
import { BoxPolynomials } from '@src/patches/box_polynomials';
import { numberEdges } from '@src/patches/plan/edge_numbers';
import { bendOf, levelOf, patternCodes, shrinkOf } from '@src/patches/levels/edge_levels';
import type { PatchPlan } from '@src/patches/plan/patch_plan';
import { PlanReader } from '@src/patches/plan/plan_reader';
import { SeamStates } from '@src/patches/seam_states';
import { RandomNumbers } from '../../support/random_numbers';
import { randomPlan } from '../../support/random_plan';

async function read(parts: readonly PatchPlanPart[]): Promise<PatchPlan> {
  return PlanReader.read((async function* () { yield* parts; })());
}

/** The parts with a change to one of them. */
function spoilt(parts: readonly PatchPlanPart[], at: number, change: (part: { header: PatchPlanHeader; run: PatchRun; seams: PatchSeams }) => void): PatchPlanPart[] {
  const copies = parts.map((part) => clone(PatchPlanPartSchema, part));
  const { part } = copies[at];
  change({ [part.case!]: part.value } as never);
  return copies;
}

for (const mode of [NormalMode.FACET, NormalMode.SMOOTH, NormalMode.NONE]) {
  test(`a plan with ${NormalMode[mode]} normals is read as it was written`, async () => {
    const made = await randomPlan(1, [2, 1, 3], mode);

    const plan = await read(made.parts);

    assert.deepEqual([...plan.corners], made.patches.flatMap(({ corners }) => corners));
    assert.deepEqual([...plan.places], made.places.flat());
    assert.equal(plan.insideCount, made.patches.findIndex(({ isOutside }) => isOutside));
    assert.equal(plan.edgeCount, made.edgeCount);
    assert.deepEqual([plan.origin, plan.outside, plan.curvatureUnit], [made.origin, made.outside, 2 ** -30]);
    assert.equal(plan.hasNormals, mode !== NormalMode.NONE);
    const normals = Array.from(plan.cornerNormals, (normal) => [...plan.restNormals.subarray(3 * normal, 3 * normal + 3)]);
    made.restNormals.flat().forEach((expected, at) =>
      expected.forEach((x, axis) => assert.ok(Math.abs(normals[at][axis] - x) < 1e-7, `${normals[at]} in place of ${expected}`)));
    assert.equal(normals.length, 3 * plan.patchCount);
  });
}

for (const mode of [NormalMode.FACET, NormalMode.SMOOTH, NormalMode.NONE]) {
  test(`weights with ${NormalMode[mode]} normals are read as they were written`, async () => {
    const made = await randomPlan(1, [2, 1, 3], mode, true);

    const plan = await read(made.parts);

    assert.deepEqual([...plan.weights!], made.weights);
    assert.ok(new Set(made.weights).size > 10);
    if (mode === NormalMode.NONE) assert.equal(plan.slopes, undefined);
    else assert.deepEqual([...plan.slopes!], made.slopes.flat());
    assert.deepEqual([...plan.places], made.places.flat());
    await assert.rejects(read(spoilt(made.parts, 0, ({ header }) => (header.weighted = false))), /longer than \d+ bytes/);
  });
}

test('a plan without weights has none', async () => {
  const { weights, slopes } = await read((await randomPlan(1, [2, 1, 3], NormalMode.FACET)).parts);
  assert.deepEqual([weights, slopes], [undefined, undefined]);
});

test('a plan that is cut short, or contradicts itself, is refused in words', async () => {
  const { parts } = await randomPlan(2, [2, 2, 2], NormalMode.FACET);
  const [header, first, second, third, seams] = parts;
  await assert.rejects(read([]), /is empty/);
  await assert.rejects(read([first, second]), /does not begin with its header/);
  await assert.rejects(read([header, first, second, seams]), /ended after \d+ of \d+ patches/);
  await assert.rejects(read([header, second, third, seams]), /begins at patch \d+ in place of 0/);
  await assert.rejects(read(spoilt(parts, 0, ({ header: h }) => (h.edgeCount += 1n))), /\d+ edges in place of/);
  await assert.rejects(read(spoilt(parts, 0, ({ header: h }) => (h.patchCount = 1n))), /does not fit its header/);
  await assert.rejects(read(spoilt(parts, 0, ({ header: h }) => (h.patchCount = 1n << 40n))), /too large/);
  await assert.rejects(read(spoilt(parts, 1, ({ run }) => (run.data = run.data.subarray(0, 20)))), /cannot be read/);
  await assert.rejects(read(spoilt(parts, 1, ({ run }) => (run.data = Uint8Array.from(run.data, (byte, i) => (i === 0 ? 0 : byte))))), /cannot be read/);
  await assert.rejects(read(spoilt(parts, 1, ({ run }) => --run.patches)), /longer than \d+ bytes/);
  await assert.rejects(read(spoilt(parts, 3, ({ run }) => ++run.newVertices)), /does not fit its header/);
  await assert.rejects(read(spoilt(parts, 1, ({ run }) => ++run.newVertices)), /\d+ bytes in place of/);
  await assert.rejects(read(spoilt(parts, 4, ({ seams: s }) => s.vertexSeams.pop())), /contradict/);
  await assert.rejects(read(spoilt(parts, 4, ({ seams: s }) => (s.edgeSeams[0] = 1))), /contradict/);
  const { patches } = await read(parts).then((plan) => ({ patches: plan.patchCount }));
  assert.ok(patches > 20);
});

test('edges are numbered by patches in the order of first use, whichever way a patch runs along them', () => {
  //   0---1      patches 0 1 2, 2 1 3, 3 1 0
  const { edges, before } = numberEdges(Uint32Array.of(0, 1, 2, 2, 1, 3, 3, 1, 0), 4);
  assert.deepEqual([...edges], [0, 1, 2, 1, 3, 4, 3, 0, 5]);
  assert.deepEqual([...before], [0, 3, 5, 6]);
});

test('the level of an edge is the least whose error is within the tolerance, at most 5', () => {
  const unit = 2 ** -20;
  for (const tolerance of [1e-9, 1e-6, 1e-4, 0.03, 5]) {
    const levels = Array.from({ length: 256 }, (_, byte) => levelOf(bendOf(byte, unit), tolerance));
    for (let byte = 0; byte < 255; ++byte) {
      const level = levels[byte];
      const error = (k: number): number => (unit * Math.SQRT2 ** byte) / 6 / 4 ** k;
      assert.ok(level === 5 || error(level) <= tolerance * (1 + 1e-12), `${byte}: ${level}`);
      assert.ok(level === 0 || error(level - 1) > tolerance * (1 - 1e-12), `${byte}: ${level}`);
    }
    assert.equal(levels[255], 5);
  }
  assert.equal(levelOf(bendOf(0, 1), 1 / 6), 0); // E = 6 t exactly
  assert.equal(levelOf(bendOf(4, 1), 1 / 6), 1); // E = 4: exactly at level 1
  assert.equal(levelOf(bendOf(5, 1), 1 / 6), 2);
  assert.equal(bendOf(255, unit), Infinity);
  assert.ok(Math.abs(bendOf(3, unit) * shrinkOf(2) - (unit * 2 ** 1.5) / 96) < 1e-20);
  assert.deepEqual([...patternCodes(Uint32Array.of(9, 9, 9, 0, 1, 2), Uint8Array.of(1, 0, 5), 1, 2)], [0o501]);
});

/** The domain's parameter in the middle of a span, and off it. */
function parameterIn(knots: Float64Array, degree: number, size: number, span: number, l: number): number {
  const distinct = [...new Set(knots.subarray(degree, size + 1))];
  return (distinct[span] + distinct[span + 1]) / 2 + l * (distinct[span + 1] - distinct[span]);
}

for (const degree of [[1, 2, 3], [3, 1, 2], [2, 2, 2]] as const) {
  test(`box polynomials of degrees ${degree.join(' x ')} are the deformation; a moved control point changes the boxes that it affects`, async () => {
    const { lattice, outside, origin } = await randomPlan(4, degree, NormalMode.NONE);
    const boxes = new BoxPolynomials(lattice, origin, outside);
    const random = new RandomNumbers(5);
    const check = (): void => {
      for (let n = 0; n < 200; ++n) {
        const l = [0, 1, 2].map(() => random.next() - 0.5) as unknown as Vec3;
        const spans = [0, 1, 2].map((axis) => random.below(new Set(lattice.knots[axis]).size - 1));
        const found = new Float64Array(3);
        boxes.at(1 + spans.reduce((sum, span, axis) => sum + span * boxes.steps[axis], 0), l, found, 0);
        const expected = evaluate(lattice, [0, 1, 2].map((axis) =>
          parameterIn(lattice.knots[axis], degree[axis], lattice.size[axis], spans[axis], l[axis])) as unknown as Vec3);
        expected.forEach((x, axis) => assert.ok(Math.abs(origin[axis] + found[axis] - x) < 2e-6, `${found} in place of ${expected}`));
      }
    };

    const all = boxes.update(lattice.points);
    assert.equal(all.length, boxes.boxCount - 1);
    check();
    lattice.points[0] += 1;
    boxes.moved([0]);
    assert.deepEqual(boxes.update(lattice.points), [1]);
    check();
    assert.deepEqual(boxes.update(lattice.points), []);
    const found = new Float64Array(3);
    boxes.at(0, [-0.5, 0.5, 0], found, 0);
    assert.deepEqual([...found], [0 - 11, -2 + 4, 2.5 - 3]);
  });
}

for (const factor of [1, 1000]) {
  test(`no point of a box moves further from its place at rest than is said, with moves ${factor} times as large`, async () => {
    const { lattice, identity, outside, origin } = await randomPlan(7, [1, 2, 3], NormalMode.NONE);
    const boxes = new BoxPolynomials(lattice, origin, outside);
    boxes.update(lattice.points.map((x, at) => identity[at] + factor * (x - identity[at])));
    const random = new RandomNumbers(8);
    const [moved, atRest] = [new Float64Array(3), new Float64Array(3)];
    for (let box = 1; box < boxes.boxCount; ++box) {
      const most = boxes.largestMove(box);
      const seen = [0, 0, 0];
      for (let n = 0; n < 300; ++n) {
        const l = [0, 1, 2].map(() => (n % 2 ? random.next() - 0.5 : random.below(2) - 0.5)) as unknown as Vec3;
        boxes.weightedAt(box, l, 1, moved, 0);
        boxes.weightedAt(box, l, 0, atRest, 0);
        moved.forEach((x, axis) => (seen[axis] = Math.max(seen[axis], Math.abs(x - atRest[axis]))));
      }
      seen.forEach((x, axis) => assert.ok(x <= most[axis] + 1e-5 && most[axis] <= 8 * x + 1e-5, `${most} of box ${box}, which moves by ${seen}`));
    }
    assert.deepEqual(boxes.largestMove(0), [0, 0, 0]);
  });
}

test('a seam is attached while all of its control points are exactly where the lattice leaves the mesh as it is', async () => {
  const { parts, lattice, identity } = await randomPlan(6, [2, 2, 2], NormalMode.NONE);
  const { seams } = await read(parts);
  const states = new SeamStates(seams, lattice.size);
  const points = identity.slice();

  assert.equal(states.update(points), true);
  assert.deepEqual([...states.isAttached], [1]);
  points[3] += 1; // (1, 0, 0), which no seam needs
  assert.equal(states.update(points), false);
  const held = 3 * lattice.size[0];
  points[held] += Math.abs(points[held]) * 2 ** -52; // (0, 1, 0)
  assert.equal(states.update(points), true);
  assert.deepEqual([...states.isAttached], [0]);
  assert.throws(() => new SeamStates({ ...seams, identityPoints: identity.subarray(0, 3) }, lattice.size), /lacks identity points/);
});

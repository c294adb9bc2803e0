// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Boxes around chunks that the page evaluates, against points of the definition.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { TopologySchema } from 'latticed/v1/event_pb';
import { NormalMode } from 'latticed/v1/view_pb';
import type { Axes } from '@src/lattice/grid';
import { BoxPolynomials } from '@src/patches/box_polynomials';
import { ChunkExtents } from '@src/patches/chunk_extents';
import { CornerPositions } from '@src/patches/corner_positions';
import { PatchTables } from '@src/patches/gpu/patch_tables';
import { PlanReader } from '@src/patches/plan/plan_reader';
import { TopologyLayout } from '@src/surface/topology_layout';
import { randomPlan } from '../support/random_plan';
import { referencePoint } from '../support/reference_patches';

const ROUNDING = 1.2e-4; // half a 65535th of the outside box, which is 15 units long
const PARTS = 8; // of a patch's edges

const CASES: readonly (readonly [Axes, isTorn: boolean, isWeighted: boolean])[] = [
  [[1, 1, 1], false, false], [[2, 2, 2], false, false], [[3, 3, 3], true, false], [[1, 3, 2], true, false], [[2, 2, 2], false, true], [[1, 3, 2], true, true]];
for (const [seed, [degree, isTorn, isWeighted]] of CASES.entries()) {
  test(`degrees ${degree.join(' x ')}${isWeighted ? ', with weights' : ''}: a chunk's box holds all points of its patches, also between their corners`, async () => {
    const made = await randomPlan(seed, degree, NormalMode.NONE, isWeighted);
    if (isTorn) made.lattice.points[0] += 0.4; // of the face that the patches outside hang on
    const plan = await PlanReader.read((async function* () { yield* made.parts; })());
    const { patchCount } = plan;
    const layout = new TopologyLayout(create(TopologySchema, {
      topologyId: 'a', patchCount: BigInt(patchCount), chunkRuns: [{ chunkCount: patchCount, patchesPerChunk: 1 }] }));
    const boxes = new BoxPolynomials(made.lattice, plan.origin, plan.outside);
    const tables = new PatchTables(plan, boxes.steps, () => false);
    const corners = new CornerPositions(plan, layout, boxes, (patch) => tables.boxOf(patch));
    const extents = new ChunkExtents(plan, layout, boxes, corners, (patch) => tables.boxOf(patch));
    const changed = boxes.update(made.lattice.points);
    corners.update();
    extents.update(changed);

    let bent = 0;
    const excess: number[] = [];
    for (let patch = 0; patch < patchCount; ++patch) {
      const extent = extents.of(patch);
      const at = (i1: number, i2: number): number[] =>
        referencePoint(made, patch, [PARTS - i1 - i2, i1, i2], !isTorn).position.map((x, axis) => x - plan.origin[axis]);
      const flat = [at(0, 0), at(PARTS, 0), at(0, PARTS)];
      const points: number[][] = [];
      for (let i1 = 0; i1 <= PARTS; ++i1) for (let i2 = 0; i1 + i2 <= PARTS; ++i2) points.push(at(i1, i2));
      for (const axis of [0, 1, 2]) {
        const all = points.map((point) => point[axis]);
        const [low, high] = [Math.min(...all), Math.max(...all)];
        assert.ok(extent[axis] <= low + ROUNDING && extent[axis + 3] >= high - ROUNDING, `patch ${patch}, axis ${axis}`);
        const ends = flat.map((corner) => corner[axis]);
        if (low < Math.min(...ends) - ROUNDING || high > Math.max(...ends) + ROUNDING) ++bent;
        excess.push(extent[axis + 3] - extent[axis] - (high - low));
      }
    }
    assert.ok(degree.every((n) => n === 1) || bent > 5, `${bent} patches leave the box of their corners`);
    const largest = Math.max(...excess);
    assert.ok(largest < (isWeighted ? 0.8 : 0.2), `boxes are larger by up to ${largest}`); // in a lattice of 5 units
  });
}

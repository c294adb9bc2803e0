// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium where it evaluates the patches of several lattices by itself: their sum comes with the updates. Also of
// vertices with weights.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { followsServer } from './against_server';
import { errors, OBJ, page, setView, until, useStage } from '../support/stage';
import { createScene, dropFiles } from '../support/viewer_page';

useStage({
  begin: async () => {
    await dropFiles(page, [['torus.obj', OBJ]]);
    await createScene(page);
    await setView({ normals: 'facet' }); // as the server evaluates
    await until(async () => page.evaluate(() => window.latticed.scene!.session.surface.edgeBounds.normals === 2));
  },
});

function apply(lattice: number, indices: readonly number[], offset: readonly [number, number, number]): Promise<void> {
  return page.evaluate(([k, list, by]) => {
    const { session } = window.latticed.scene!;
    session.chooseLattice(k);
    session.apply({ kind: 'move', indices: Uint32Array.from(list), offset: by as never });
  }, [lattice, indices, offset] as const);
}

const isEvaluated = (): Promise<boolean> => page.evaluate(() => window.latticed.scene!.isEvaluated);

test('a lattice that is added brings another plan, and the page goes on to evaluate', async () => {
  await apply(0, [63], [0.5, 0.25, 0.75]);
  const before = await page.evaluate(() => {
    const { session } = window.latticed.scene!;
    const { lattice } = session;
    const { origin, u, v, w } = lattice.frame; // along x, y and z
    const edges = { u: [0.5 * u[0], 0, 0], v: [0, 0.75 * v[1], 0], w: [0, 0, 0.75 * w[2]] };
    // The points at rest, in the smaller frame.
    const sizes = [u[0], v[1], w[2]];
    const places = [0, 0.25, 0.75, 1]; // Greville points of 4 control points of degree 2
    const at = (n: number, axis: number): number =>
      origin[axis]! + (axis === 0 ? 0.5 : 0.75) * sizes[axis]! * places[Math.floor(n / 4 ** axis) % 4]!;
    const part = Object.assign(Object.create(Object.getPrototypeOf(lattice) as object), lattice, {
      frame: { origin, ...edges }, points: Float64Array.from({ length: 192 }, (_, i) => at(Math.floor(i / 3), i % 3)),
      outside: { mode: 'falloff', smooth: true, widths: [0, 0.4, 0, 0.3, 0, 0.3], steps: [] },
    }) as typeof lattice;
    session.addLattice(part);
    return session.surface.patchCount;
  });
  await page.waitForFunction((count) => {
    const { session } = window.latticed.scene!;
    return session.latticeIndex === 1 && session.surface.edgeBounds.sum !== undefined && session.surface.patchCount !== count;
  }, before);
  await followsServer(page, OBJ);
  assert.ok(await isEvaluated());
  assert.deepEqual(errors, []);
});

test('an edit of each is seen at once, as its update then brings it', async () => {
  for (const lattice of [0, 1]) {
    await page.evaluate((k) => window.latticed.scene!.session.chooseLattice(k), lattice);
    await page.waitForFunction((k) => window.latticed.scene!.session.shownLatticeIndex === k, lattice);
    const { shown, moved } = await page.evaluate(() => {
      const { session } = window.latticed.scene!;
      const before = session.surface.edgeBounds.sum!.points;
      session.apply({ kind: 'move', indices: Uint32Array.of(21, 42), offset: [0.25, 0.0625, 0.125] });
      window.latticed.scene!['evaluation']['draw'](); // before the update comes
      const { points } = window.latticed.scene!['evaluation']['shownSum']!;
      return { shown: [...points], moved: points.filter((x, i) => x !== before[i]).length };
    });
    assert.ok(moved > 0 && moved < shown.length);
    await followsServer(page, OBJ);
    await until(async () => page.evaluate(() => !window.latticed.scene!['evaluation']['isAhead']));
    const come = await page.evaluate(() => [...window.latticed.scene!.session.surface.edgeBounds.sum!.points]);
    const worst = Math.max(...come.map((x, i) => Math.abs(x - shown[i]!)));
    assert.ok(worst < 1e-13, `${worst}`);
  }
});

test('edits of each and their undo follow the server', async () => {
  for (const lattice of [1, 0, 1]) {
    await apply(lattice, [37, 38], [0.125, 0.25, -0.125]);
    await followsServer(page, OBJ);
  }
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await followsServer(page, OBJ);
  assert.ok(await isEvaluated());
  assert.deepEqual(errors, []);
});

test('vertices with weights are evaluated, too, and so they are without them again', async () => {
  const plan = await page.evaluate(() => window.latticed.scene!.session.surface.edgeBounds.layout!.id);
  const otherPlan = (id: string): Promise<unknown> =>
    page.waitForFunction((before) => window.latticed.scene!.session.surface.edgeBounds.layout!.id !== before, id);
  await page.evaluate(() => window.latticed.scene!.session.setWeights(
    Array.from({ length: 60 }, (_, i) => i), Float32Array.from({ length: 60 }, (_, i) => (i % 7) / 6)));
  await otherPlan(plan);
  await followsServer(page, OBJ);
  await apply(1, [37], [0.125, 0, 0.125]);
  await followsServer(page, OBJ);
  assert.ok(await isEvaluated());
  const weighted = await page.evaluate(() => window.latticed.scene!.session.surface.edgeBounds.layout!.id);
  await page.evaluate(() => {
    window.latticed.scene!.session.chooseLattice(0);
    window.latticed.scene!.session.undo();
  });
  await otherPlan(weighted);
  await followsServer(page, OBJ);
  assert.ok(await isEvaluated());
  assert.deepEqual(errors, []);
});

test('an edit is measured once', async () => {
  const measured = (): Promise<number> =>
    page.evaluate(() => (window.latticed as unknown as { hud: { latencies: number[] } }).hud.latencies.length);
  const before = await measured();
  await apply(1, [37], [0, 0.125, 0]);
  await followsServer(page, OBJ);
  await until(async () => (await measured()) > before);
  assert.equal(await measured(), before + 1);
});

test('of lattices that are removed and given back the page shows what is left, also if all have the same structure', async () => {
  const shows = (numbers: readonly number[]): Promise<unknown> => page.waitForFunction((wanted) => {
    const { latticeNumbers, surface } = window.latticed.scene!.session;
    return latticeNumbers.join() === wanted && (surface.edgeBounds.sum !== undefined) === wanted.includes(',');
  }, numbers.join());
  const removeShown = (): Promise<void> => page.evaluate(() => window.latticed.scene!.session.removeLattice());
  await apply(1, [37], [0, 0, 0.125]);
  await followsServer(page, OBJ);
  await removeShown();
  await shows([0]);
  await followsServer(page, OBJ);

  await page.evaluate(() => {
    const { session } = window.latticed.scene!;
    session.addLattice(session.lattice.clone());
  });
  await shows([0, 1]);
  await followsServer(page, OBJ);
  await removeShown();
  await shows([0]);
  await followsServer(page, OBJ);
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await shows([0, 1]);
  await followsServer(page, OBJ);
  await page.evaluate(() => window.latticed.scene!.session.chooseLattice(0));
  await removeShown();
  await shows([1]);
  await followsServer(page, OBJ);
  assert.ok(await isEvaluated());
  assert.deepEqual(errors, []);
});

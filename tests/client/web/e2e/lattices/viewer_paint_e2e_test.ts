// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The brush for vertex weights in the viewer in Chromium: a stroke shows its colours, is one edit, and is undone as one.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { errors, direct, openTorus, page, press, shot, until, useStage } from '../support/stage';
import { createScene, dropFiles, frames, meshUploaded } from '../support/viewer_page';

useStage({ context: { viewport: { width: 920, height: 560 } }, begin: openTorus });

/** A place of the page on the side of the torus near the camera. */
function nearPlace(): Promise<[number, number]> {
  return page.evaluate(() => {
    const { viewport, scene } = window.latticed;
    const { bounds } = scene!.session.surface;
    const away = viewport.rig.basis()[2];
    const [x, y] = viewport.project([away[0] * 1.1, away[1] * 1.1, bounds.max.z * 0.5])!;
    const box = viewport.canvas.getBoundingClientRect();
    return [box.left + x, box.top + y] as [number, number];
  });
}

function weightsCome(): Promise<unknown> {
  return page.waitForFunction(() => window.latticed.scene!.session.surface.painted !== undefined);
}

function weights(): Promise<number[]> {
  return page.evaluate(() => [...window.latticed.scene!.session.surface.painted!.weights]);
}

async function scene(): Promise<{ weighted: boolean; revision: bigint }> {
  const id = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  return direct.scenes.getScene({ scene: id });
}

function revisionComes(revision: number): Promise<unknown> {
  return page.waitForFunction((wanted) => {
    const { session } = window.latticed.scene!;
    return session.isAt(wanted) && session.canUndo;
  }, revision);
}

test('a stroke paints what it passes, and is one edit', async () => {
  const [x, y] = await nearPlace();
  await press('w');
  await weightsCome();
  assert.ok((await weights()).every((weight) => weight === 1));
  await page.evaluate(() => window.latticed.settings.set({ brush: { radius: 60, strength: 1, weight: 0 } }));

  await page.mouse.move(x - 40, y);
  await page.mouse.down();
  for (let step = 1; step <= 8; ++step) await page.mouse.move(x - 40 + 10 * step, y);
  const shown = await weights();
  await shot('viewer_paint_stroke');
  await page.mouse.up();

  const painted = shown.filter((weight) => weight < 0.5).length;
  assert.ok(painted >= 1 && painted < shown.length / 2, `${painted} of ${shown.length}`);
  await revisionComes(1);
  assert.equal((await scene()).revision, 1n);
  assert.equal((await scene()).weighted, true);
  await page.waitForFunction((expected) => {
    const now = window.latticed.scene!.session.surface.painted?.weights;
    return now !== undefined && now.every((weight, vertex) => Math.abs(weight - expected[vertex]!) < 1e-6);
  }, shown);
});

test('what is painted rests, the rest follows the lattice', async () => {
  await page.evaluate(() => {
    const { session } = window.latticed.scene!;
    const indices = Uint32Array.from({ length: 64 }, (_, i) => i);
    session.apply({ kind: 'move', indices, offset: [0, 0, 1] });
  });
  await revisionComes(2);
  const heights = async (): Promise<readonly [lowest: number, highest: number]> => {
    await frames(page);
    return page.evaluate(() => {
      const { surface } = window.latticed.scene!.session;
      const all = [...(surface.painted ? surface.vertexPlaces() : [])].filter((_, i) => i % 3 === 2);
      return [Math.min(...all), Math.max(...all)] as const;
    });
  };
  await until(async () => { // the surface comes some time after the revision
    const [lowest, highest] = await heights();
    return highest - lowest > 1;
  }, heights);
  await shot('viewer_paint_moved');
});

test('undo takes the stroke back as one step', async () => {
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await revisionComes(3);
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await page.waitForFunction(() => window.latticed.scene!.session.surface.painted?.weights.every((weight) => weight === 1));
  assert.equal((await scene()).weighted, false);
  assert.deepEqual(errors, []);
});

const PLY = `ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property float weight
element face 4
property list uchar int vertex_indices
end_header
0 0 0 0
1 0 0 1
0 1 0 0.5
0 0 1 1
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
`;

test('a scene takes the weights of a dropped file, unless that is switched off', async () => {
  for (const takes of [true, false]) {
    await dropFiles(page, [['weights.ply', PLY]]);
    await meshUploaded(page);
    if (!takes) await page.getByRole('switch', { name: 'Weights of the file' }).click();
    await createScene(page);
    assert.equal((await scene()).weighted, takes);
    await press('w');
    await weightsCome();
    assert.deepEqual(await weights(), takes ? [0, 1, 0.5, 1] : [1, 1, 1, 1]);
  }
  assert.deepEqual(errors, []);
});

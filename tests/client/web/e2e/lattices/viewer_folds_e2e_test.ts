// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds in the viewer in Chromium: the count, the red boxes, and the switch that refuses them.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import type { Locator } from 'playwright-core';
import { allPoints, direct, errors, openTorus, page, press, select, shot, until, useStage } from '../support/stage';
import { frames, onScreen } from '../support/viewer_page';

/** Inner control points of 4 x 4 x 4, in a column. */
const COLUMN = [22, 26, 38, 42] as const;

const count = (): Promise<string> => page.locator('[data-hud=folds]').innerText();
const comes = (text: RegExp): Promise<unknown> => until(async () => text.test(await count()));
const refuse = (): Locator => page.getByRole('switch', { name: 'Refuse folds' });

async function certified(): Promise<boolean> {
  const scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  return (await direct.scenes.certifyFolds({ scene })).certified;
}

function drawn(): Promise<number> {
  return page.evaluate(() => (window.latticed.scene as unknown as { foldedBoxes: { count: number } }).foldedBoxes.count);
}

useStage({ context: { viewport: { width: 920, height: 560 } }, begin: () => openTorus() });

beforeEach(async () => {
  await press('Escape'); // messages
  await page.evaluate(() => {
    window.latticed.settings.set({ refuseFolds: false });
    window.latticed.commands.get('reset').run();
  });
  await comes(/^0$/);
  await select(...COLUMN);
});

test('boxes that fold are counted, drawn in red, and gone after an undo', async () => {
  assert.equal(await drawn(), 0);
  await press('g', 'x', '1', '.', '2', 'Enter');

  await comes(/^4$/); // of eight knot boxes
  assert.equal(await drawn(), 4);
  assert.equal(await certified(), false);
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await frames(page);
  await shot('folds');
  await press('Control+z');
  await comes(/^0$/);
  assert.equal(await drawn(), 0);
});

test('the switch stops a move at the last state without a fold', async () => {
  await refuse().check();
  await press('g', 'x', '.', '1', 'Enter');
  const before = await allPoints();
  await press('g', 'x', '9', 'Enter');

  await page.getByText('The lattice would fold over itself').waitFor();
  await until(async () => String(await allPoints()) === String(before));
  assert.ok(await certified());
  await comes(/^0$/);
  await press('g', 'x', '.', '1', 'Enter');
  await until(async () => String(await allPoints()) !== String(before));
  await press('Control+z');
  await until(async () => String(await allPoints()) === String(before));
});

/** A place of the page on the side of the torus near the camera. */
function nearPlace(): Promise<[number, number]> {
  return page.evaluate(() => {
    const { viewport, scene } = window.latticed;
    const { min, max } = scene!.session.surface.bounds;
    const away = viewport.rig.basis()[2];
    const [x, y] = viewport.project([(min.x + max.x) / 2 + away[0] * 1.1, (min.y + max.y) / 2 + away[1] * 1.1, max.z / 2])!;
    const box = viewport.canvas.getBoundingClientRect();
    return [box.left + x, box.top + y] as [number, number];
  });
}

/** Paints a spot that no longer follows the lattice. Returns how many weights show it. */
async function paintSpot(): Promise<number> {
  await page.waitForFunction(() => window.latticed.scene!.session.surface.painted !== undefined);
  await page.mouse.move(...(await nearPlace()));
  await page.mouse.down();
  const painted = await page.evaluate(() => window.latticed.scene!.session.surface.painted!.weights.filter((w) => w < 0.5).length);
  await page.mouse.up();
  return painted;
}

test('a stroke of the brush that would fold is not made, and the weights are those before', async () => {
  const isWeighted = async (): Promise<boolean> => {
    const scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
    return (await direct.scenes.getScene({ scene })).weighted;
  };
  await refuse().check();
  await page.evaluate(() => {
    const { scene, settings } = window.latticed;
    scene!.session.apply({ kind: 'move', indices: Uint32Array.from({ length: 64 }, (_, i) => i), offset: [9, 0, 0] });
    settings.set({ tool: 'paint', brush: { radius: 60, strength: 1, weight: 0 } });
  });
  await page.waitForFunction(() => window.latticed.scene!.session.surface.bounds.min.x > 5);
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await frames(page);
  assert.ok((await paintSpot()) > 0);

  await page.getByText('The lattice would fold over itself').waitFor();
  await page.waitForFunction(() => window.latticed.scene!.session.surface.painted?.weights.every((weight) => weight === 1));
  assert.equal(await isWeighted(), false);
  await comes(/^0$/);
  assert.ok(await certified());

  await page.evaluate(() => window.latticed.settings.set({ refuseFolds: false }));
  assert.ok((await paintSpot()) > 0);
  await until(isWeighted);
  await comes(/^[1-9]/);
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await until(async () => !(await isWeighted()));
  await page.evaluate(() => window.latticed.settings.set({ tool: 'select' }));
});

test('a drag by the mouse stops where it would fold', async () => {
  await refuse().check();
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await frames(page);
  const before = await allPoints();
  const [x, y] = await onScreen(page, COLUMN[0]);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= 20; ++step) await page.mouse.move(x + 2 * step ** 2, y);
  await page.getByText('The lattice would fold over itself').waitFor();
  await page.mouse.up();

  await until(async () => (await count()) === '0' && (await certified()));
  await page.waitForFunction(() => window.latticed.scene!.session.canUndo);
  assert.notDeepEqual(await allPoints(), before); // it stays where it was last good
  await press('Control+z');
  await until(async () => String(await allPoints()) === String(before));
  assert.deepEqual(errors, []);
});

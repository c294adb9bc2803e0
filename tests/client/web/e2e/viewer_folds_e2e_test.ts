// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds in the viewer in Chromium: the count, the red boxes, and the switch that refuses them.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import type { Locator } from 'playwright-core';
import { allPoints, direct, errors, openTorus, page, press, select, shot, until, useStage } from './stage';
import { frames, onScreen } from './viewer_page';

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

useStage({ context: { viewport: { width: 1000, height: 640 } }, begin: () => openTorus() });

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

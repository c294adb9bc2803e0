// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether every text and button of the viewer can be read, in both themes, on a wide and a narrow window.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { illegible } from '../support/legibility';
import { errors, openTorus, page, press, shot, useStage } from '../support/stage';
import { dropFiles, meshUploaded } from '../support/viewer_page';
import { torusObj } from '../support/torus';

const BACK = { dark: '#14181f', light: '#f3f5f9' }; // App.setDark
const WIDE = 1280;
const SHOWN = ['start', 'scene']; // of which there are pictures: each takes a second
const MENUS = ['File', 'Edit', 'Select', 'View'];

useStage({ context: { viewport: { width: WIDE, height: 800 }, colorScheme: 'dark' } });

/** Looks at what is shown in each theme and width. */
async function look(what: string): Promise<void> {
  const found: string[] = [];
  for (const width of [WIDE, 768]) {
    await page.setViewportSize({ width, height: 800 });
    for (const theme of ['dark', 'light'] as const) {
      await page.evaluate((chosen) => window.latticed.settings.set({ theme: chosen }), theme);
      found.push(...(await illegible(page, BACK[theme])).map((problem) => `${what}, ${theme}, ${width} px: ${problem}`));
      if (SHOWN.includes(what) && width === WIDE) await shot(`viewer_${what}_${theme}_${width}`);
    }
  }
  assert.deepEqual(found, []);
}

test('the start page', () => look('start'));

test('the dialog that fits a lattice', async () => {
  await dropFiles(page, [['torus.obj', torusObj(12, 8)]]);
  await meshUploaded(page);
  await look('fit');
  await page.getByRole('button', { name: 'Cancel' }).click();
  await page.locator('dialog').waitFor({ state: 'detached' });
});

test('a scene with its panel, and a message', async () => {
  await openTorus();
  await page.evaluate(() => {
    window.latticed.settings.set({ panel: true, compare: 'split', colouring: 'difference' });
    window.latticed.toasts.fail('A message, which stays for a while.');
  });
  await look('scene');
  await page.evaluate(() => window.latticed.settings.set({ compare: 'off', colouring: 'plain' }));
});

test('the dialog for name and colour', async () => {
  await page.locator('.dot.you').click();
  await look('you');
  await press('Escape');
});

for (const menu of MENUS) {
  test(`the menu ${menu}`, async () => {
    await page.locator('.menu-button').getByText(menu, { exact: true }).click();
    await look(`menu_${menu.toLowerCase()}`);
    await press('Escape');
  });
}

for (const [what, open] of [['export', 'Control+e'], ['help', '?'], ['knot', 'k']] as const) {
  test(`the dialog ${what}`, async () => {
    await press(open);
    await page.locator('dialog[open]').waitFor();
    await look(what);
    await press('Escape');
  });
}

test('no errors', () => assert.deepEqual(errors, []));

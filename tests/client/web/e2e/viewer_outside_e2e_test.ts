// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What goes on outside the lattice, in the viewer in Chromium: the dialog, the handles on the box, and what the page draws.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openTorus, page, press, shot, useStage } from './stage';

useStage({ context: { viewport: { width: 1000, height: 800 } }, begin: openTorus });

interface Shown { mode: string; smooth: boolean; widths: number[] }

function outside(): Promise<Shown | undefined> {
  return page.evaluate(() => {
    const { outside: shown } = window.latticed.scene!.session.lattice;
    return shown && { mode: shown.mode, smooth: shown.smooth, widths: [...shown.widths] };
  });
}

async function openDialog(): Promise<void> {
  await page.evaluate(() => window.latticed.scene!.chooseOutside());
  await page.locator('dialog.outside').waitFor();
}

function modeComes(mode: string | undefined): Promise<unknown> {
  return page.waitForFunction((wanted) => window.latticed.scene!.session.lattice.outside?.mode === wanted, mode);
}

test('handles change the widths of a falloff, and the scene has them', async () => {
  await openDialog();
  await page.getByRole('radio', { name: 'Falloff' }).click();
  const handle = page.getByRole('slider', { name: 'Width at the end of u' });
  await handle.focus();
  await press('ArrowUp', 'ArrowUp');
  assert.equal(await handle.getAttribute('aria-valuenow'), '0.400');

  const other = page.getByRole('slider', { name: 'Width at the begin of u' });
  const box = (await other.boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const end = (await handle.boundingBox())!;
  const [ox, oy] = [x - (end.x + end.width / 2), y - (end.y + end.height / 2)];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 0.1 * ox, y + 0.1 * oy, { steps: 4 });
  await page.mouse.up();
  assert.ok(Number(await other.getAttribute('aria-valuenow')) > 0.35);
  const scrolled = await page.evaluate(() => window.latticed.viewport.element.scrollLeft);
  assert.equal(scrolled, 0, 'a handle beyond the edge does not scroll the view');
  await shot('outside');
  await page.getByText('Smooth at the faces').click();
  await page.getByRole('button', { name: 'Change' }).click();

  await modeComes('falloff');
  const shown = (await outside())!;
  assert.equal(shown.smooth, false);
  assert.ok(Math.abs(shown.widths[1]! - 0.4) < 1e-12 && shown.widths[0]! > 0.35);
  assert.deepEqual(shown.widths.slice(2), [0.3, 0.3, 0.3, 0.3]);
  assert.equal(await page.locator('.outside-handle').count(), 0);
});

test('an undo takes it back, and a cancelled dialog changes nothing', async () => {
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await modeComes(undefined);
  await openDialog();
  await page.getByRole('radio', { name: 'Linear' }).click();
  assert.equal(await page.locator('.outside-handles').isHidden(), true);
  await page.getByRole('button', { name: 'Cancel' }).click();
  assert.equal(await outside(), undefined);
});

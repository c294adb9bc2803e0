// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What goes on outside the lattice, in the viewer in Chromium: the dialog, the handles on the box, and what the page draws.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { OBJ, openTorus, page, press, shot, useStage } from '../support/stage';
import { createScene, dropFiles, frames, meshUploaded } from '../support/viewer_page';

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
  assert.ok(Number(await other.getAttribute('aria-valuenow')) > 0.45);
  const scrolled = await page.evaluate(() => window.latticed.viewport.element.scrollLeft);
  assert.equal(scrolled, 0, 'a handle beyond the edge does not scroll the view');
  await shot('outside');
  const dialog = page.locator('dialog.outside');
  const all = dialog.getByRole('spinbutton', { name: 'Width of all sides' });
  assert.equal(await all.inputValue(), '', 'they differ');
  await dialog.getByText('Each side').click();
  const side = dialog.getByRole('spinbutton', { name: 'Width at the end of w' });
  assert.equal(await side.inputValue(), '0.3');
  await side.fill('0.5');
  await side.press('Tab');
  assert.equal(await page.getByRole('slider', { name: 'Width at the end of w' }).getAttribute('aria-valuenow'), '0.500');
  await page.getByText('Smooth at the faces').click();
  await page.getByRole('button', { name: 'Change' }).click();

  await modeComes('falloff');
  const shown = (await outside())!;
  assert.equal(shown.smooth, false);
  assert.ok(Math.abs(shown.widths[1]! - 0.4) < 1e-12 && shown.widths[0]! > 0.35);
  assert.deepEqual(shown.widths.slice(2), [0.3, 0.3, 0.3, 0.5]);
  await page.locator('.outside-handle').first().waitFor({ state: 'detached' });
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

test('in a small window the dialog covers no handle', async () => {
  const before = page.viewportSize()!;
  await page.setViewportSize({ width: 920, height: 560 });
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await openDialog();
  await page.getByRole('radio', { name: 'Falloff' }).click();
  await frames(page);
  await shot('outside_small');
  const covered = await page.locator('.outside-handle').evaluateAll((handles: HTMLElement[]) => handles.flatMap((handle) => {
    const { left, top, width, height } = handle.getBoundingClientRect();
    const found = document.elementFromPoint(left + width / 2, top + height / 2);
    return found?.closest('dialog') ? [handle.title] : [];
  }));
  assert.deepEqual(covered, []);
  await page.getByRole('button', { name: 'Cancel' }).click();
  await page.setViewportSize(before);
});

/** Waits until the server has taken the first change of the scene. */
function changed(): Promise<unknown> {
  return page.waitForFunction(() => window.latticed.scene!.session.canUndo && window.latticed.scene!.session.isAt(1_000));
}

/** Drops the torus again, and waits for the dialog that fits its lattice. */
async function fitDialog(): Promise<void> {
  await dropFiles(page, [['torus.obj', OBJ]]);
  await meshUploaded(page);
}

test('the dialog that fits a lattice has the same choice, and points stay unless somebody chooses', async () => {
  await fitDialog();
  const dialog = page.locator('dialog.fit');
  const width = dialog.getByRole('spinbutton', { name: 'Width of all sides' });
  assert.equal(await dialog.getByRole('radio', { name: 'Stays' }).getAttribute('aria-checked'), 'true');
  assert.equal(await width.isHidden(), true);
  await createScene(page);
  assert.equal(await outside(), undefined);
});

test('a lattice is fitted with a falloff', async () => {
  await fitDialog();
  const dialog = page.locator('dialog.fit');
  const preview = (): Promise<string> => dialog.locator('canvas').evaluate((canvas: HTMLCanvasElement) => canvas.toDataURL());
  const before = await preview();
  await dialog.getByRole('radio', { name: 'Falloff' }).click();
  assert.notEqual(await preview(), before, 'the picture shows where it ends');
  await dialog.getByText('Each side').click();
  const side = dialog.getByRole('spinbutton', { name: 'Width at the begin of v' });
  await side.fill('1/2');
  await side.press('Tab');
  assert.equal(await dialog.getByRole('spinbutton', { name: 'Width of all sides' }).inputValue(), '', 'they differ');
  await dialog.getByText('Smooth at the faces').click();
  await shot('fit_outside');
  await createScene(page);
  assert.deepEqual(await outside(), { mode: 'falloff', smooth: false, widths: [0.3, 0.3, 0.5, 0.3, 0.3, 0.3] });
});

test('the width of all sides may be the widest of different ones', async () => {
  await openDialog();
  const dialog = page.locator('dialog.outside');
  const all = dialog.getByRole('spinbutton', { name: 'Width of all sides' });
  assert.equal(await all.inputValue(), '');
  const change = page.getByRole('button', { name: 'Change' });
  await all.fill('-1');
  assert.ok(await change.isDisabled());
  await all.fill('0.5');
  await all.press('Tab');
  assert.equal(await all.inputValue(), '0.5');
  await change.click();
  await changed();
  assert.deepEqual(await outside(), { mode: 'falloff', smooth: false, widths: new Array<number>(6).fill(0.5) });
});

test('a wrong width is told, and makes no scene', async () => {
  await fitDialog();
  const dialog = page.locator('dialog.fit');
  const create = dialog.getByRole('button', { name: 'Create scene' });
  await dialog.getByRole('radio', { name: 'Falloff' }).click();
  await dialog.getByText('Each side').click();
  for (const [name, typed, why] of [['of all sides', '2000', 'A number from 0 to 1000.'], ['at the end of w', '1,,5', undefined]] as const) {
    const width = dialog.getByRole('spinbutton', { name: `Width ${name}` });
    await width.fill(typed);
    await width.press('Tab');
    assert.equal(await width.inputValue(), typed);
    assert.equal(await width.getAttribute('aria-invalid'), 'true');
    if (why) await dialog.getByText(why).waitFor();
    assert.ok(await create.isDisabled(), typed);
    await dialog.getByRole('radio', { name: 'Stays' }).click();
    assert.ok(await create.isEnabled(), 'it is not seen');
    await dialog.getByRole('radio', { name: 'Falloff' }).click();
    assert.ok(await create.isDisabled(), typed);
    await width.selectText();
    await width.pressSequentially('0.45'); // 0. is 0, and not replaced by it
    assert.equal(await width.inputValue(), '0.45');
    assert.ok(await create.isEnabled());
  }
  await dialog.getByRole('button', { name: 'Cancel' }).click();
});

test('a lattice that cannot be is not drawn', async () => {
  await fitDialog();
  const dialog = page.locator('dialog.fit');
  const preview = (): Promise<string> => dialog.locator('canvas').evaluate((canvas: HTMLCanvasElement) => canvas.toDataURL());
  await dialog.getByRole('combobox', { name: 'Degree along u' }).selectOption('3');
  await dialog.getByRole('spinbutton', { name: 'Points along u' }).fill('2');
  await dialog.getByText('needs at least 4 control points').waitFor();
  const before = await preview();
  await dialog.getByRole('radio', { name: 'Falloff' }).click();
  await dialog.getByRole('spinbutton', { name: 'Padding' }).fill('50');
  assert.equal(await preview(), before);
  await dialog.getByRole('spinbutton', { name: 'Points along u' }).fill('5');
  assert.notEqual(await preview(), before);
  await dialog.getByRole('button', { name: 'Cancel' }).click();
});

test('a linear one of a fitted lattice has widths, since the mesh is all inside; without any, points stay', async () => {
  for (const [typed, widths] of [['2', new Array<number>(6).fill(2)], ['0', undefined]] as const) {
    await fitDialog();
    const dialog = page.locator('dialog.fit');
    await dialog.getByRole('radio', { name: 'Linear' }).click();
    assert.equal(await dialog.getByText('Smooth at the faces').isHidden(), true);
    const width = dialog.getByRole('spinbutton', { name: 'Width of all sides' });
    await width.fill(typed);
    await width.press('Tab');
    await createScene(page);
    assert.deepEqual(await outside(), widths && { mode: 'linear', smooth: true, widths });
    if (!widths) continue;
    await openDialog();
    assert.equal(await page.locator('dialog.outside').getByRole('spinbutton', { name: 'Width of all sides' }).inputValue(), '2');
    await page.getByText('up to the width of each side').waitFor();
    await page.getByRole('button', { name: 'Change' }).click();
    await changed();
    assert.deepEqual(await outside(), { mode: 'linear', smooth: true, widths }, 'nothing was changed');
  }
});

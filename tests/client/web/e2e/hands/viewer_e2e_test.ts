// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium against the real server, steered by mouse and keys.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { latticeFromJson } from '@src/wire/lattice_json';
import { distance, type Vec3 } from '@src/lattice/vec';
import { openPage } from '../support/browser';
import { followsDefinition } from '../support/definition';
import { withData } from '../support/restarts';
import { browser, CORNER, errors, OBJ, page, press, selected as selection, server, setView, shot, until, useStage } from '../support/stage';
import { colourAt, controlPoint, dropFiles, frames, live, onScreen, saved } from '../support/viewer_page';


const readBacks: string[] = []; // addresses of calls for the file of a mesh

/** Waits until a window shows another's selection: a dot with its name, and a ring in its colour around a point. */
async function seesSelection(seer: Page, editor: Page, index: number, words: string): Promise<void> {
  const { name, colour } = await editor.evaluate(() => window.latticed.people.you);
  await seer.locator(`.person[title^="${name}: ${words} selected."]`).waitFor();
  await frames(seer);
  const rgb: Vec3 = [colour >> 16, (colour >> 8) & 255, colour & 255];
  const ring = await colourAt(seer, await controlPoint(seer, index), 6);
  assert.ok(distance(ring, rgb) < 8, `${ring} is not ${rgb}`); // linear colours are rounded to 8 bits
}

useStage({
  serverOptions: withData(),
  begin: async () => page.on('request', (request) => request.url().endsWith('/DownloadMesh') && readBacks.push(request.url())),
});

test('a file that is no mesh is refused in words, on the page', async () => {
  await dropFiles(page, [['broken.obj', 'f 1 2 3\n']]);

  await page
    .locator('.fit .error')
    .getByText(/vertex|vertices/i)
    .waitFor();
  await page.getByRole('button', { name: 'Cancel' }).click();
  await page.locator('dialog').waitFor({ state: 'detached' }); // until the next frame its fields are still there
  await dropFiles(page, [['part.step', 'ISO-10303-21;']]);
  await page.locator('.toast-error').getByText('part.step is no mesh').waitFor();
  errors.length = 0; // the console reports the refused call too
});

test('a dropped file becomes a scene with the lattice that is asked for', async () => {
  await dropFiles(page, [['torus.obj', OBJ]]);
  await page.getByText('96 vertices, 192 faces').waitFor();
  await page.getByRole('radio', { name: 'Z' }).click();
  await page.getByLabel('Points along u').fill('5');
  await page.getByLabel('Points along u').press('Tab');
  await page.getByText('80 control points').waitFor();
  await shot('viewer_fit');
  await page.getByLabel('Points along u').fill('1');
  await page.getByLabel('Points along u').press('Enter'); // the browser refuses it: the least is 2
  await page.getByLabel('Points along u').fill('4');
  await page.getByLabel('Points along u').press('Enter');

  await live(page);
  assert.equal(await page.locator('.toast-error').count(), 0); // that of part.step is gone
  assert.match(page.url(), /\?scene=[0-9a-f]{32}$/);
  assert.equal(await page.evaluate(() => window.latticed.scene!.session.lattice.count), 64);
  await setView({ segments: 3 }); // frames draw quickly
});

test('the mouse drags a control point: it stays below the pointer, and the surface goes where the definition says', async () => {
  const [x, y] = await onScreen(page, CORNER);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= 10; ++step) await page.mouse.move(x + 6 * step, y - 5 * step);
  await page.mouse.up();

  const [nowX, nowY] = await onScreen(page, CORNER);
  assert.ok(Math.hypot(nowX - (x + 60), nowY - (y - 50)) < 2, `${[nowX - x, nowY - y]} is not 60, -50`);
  await followsDefinition(page, OBJ);
  await shot('viewer_dragged');
});

test('G X 1 Enter moves by one along X, Ctrl-Z takes one gesture back', async () => {
  const before = await controlPoint(page, CORNER);

  await press('g', 'x', '1');
  assert.match(await page.locator('.hint').innerText(), /^Move\s+1\|\s+along X \(world\)$/);
  await page.keyboard.press('Enter');
  const moved = await controlPoint(page, CORNER);
  await page.keyboard.press('Control+z');
  await page.waitForFunction(([i, x]) => window.latticed.scene!.session.lattice.points[3 * i] === x, [
    CORNER,
    before[0],
  ] as const);

  assert.deepEqual(moved, [before[0] + 1, before[1], before[2]]);
});

test('Escape and a right click take a running transform back', async () => {
  const before = await controlPoint(page, CORNER);
  const [x, y] = await onScreen(page, CORNER);

  for (const cancel of [() => page.keyboard.press('Escape'), () => page.mouse.click(x - 90, y + 40, { button: 'right' })]) {
    await page.mouse.move(x - 40, y + 40);
    await page.keyboard.press('g');
    await page.mouse.move(x - 90, y + 40);
    assert.notDeepEqual(await controlPoint(page, CORNER), before);
    await cancel();
    assert.deepEqual(await controlPoint(page, CORNER), before);
  }
});

test('points are selected by a click, a row, a plane, a box, all and none', async () => {
  const selected = async (): Promise<number> => (await selection()).length;
  const box = (await page.locator('canvas').boundingBox())!;

  await page.mouse.click(...(await onScreen(page, CORNER)));
  assert.equal(await selected(), 1);
  await page.keyboard.press('u');
  assert.equal(await selected(), 4);
  await page.keyboard.press('Shift+W');
  assert.equal(await selected(), 16);
  await page.keyboard.press('a');
  assert.equal(await selected(), 64);
  await page.keyboard.press('Alt+a');
  assert.equal(await selected(), 0);
  await page.keyboard.press('Home');
  await page.keyboard.press('b');
  await page.mouse.move(box.x + 2, box.y + 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width - 2, box.y + box.height - 2, { steps: 3 });
  await page.mouse.up();
  await page.keyboard.press('b');
  assert.equal(await selected(), 64);
});

test('a second window shows the same scene, follows, and may insert a knot that the first one takes over', async () => {
  const { page: other, errors: otherErrors } = await openPage(browser, page.url());
  await live(other);
  await setView({ segments: 3 }, other);
  await seesSelection(other, page, CORNER, '64 control points'); // selected before it was opened
  await other.evaluate(() => window.latticed.settings.set({ colouring: 'displacement' }));
  await other.locator('.heat-legend').getByText(/^0\.\d+$/).waitFor(); // of the dragged corner; no update came

  await page.keyboard.press('Alt+a');
  await page.mouse.click(...(await onScreen(page, 0)));
  await press('g', 'z', '-', '1', 'Enter');
  const moved = await controlPoint(page, 0);
  await other.waitForFunction(([z]) => window.latticed.scene!.session.lattice.points[2] === z, [moved[2]] as const);
  await followsDefinition(other, OBJ);
  await seesSelection(other, page, 0, '1 control point');
  await other.evaluate((corner) => window.latticed.scene!.editor.selection.select([corner]), CORNER);
  await seesSelection(page, other, CORNER, '1 control point');
  await shot('viewer_presence');

  await other.keyboard.press('k');
  await other.getByLabel('Knot', { exact: true }).fill('7');
  await other.getByLabel('Knot', { exact: true }).press('Enter');
  await other.locator('.toast-error').getByText(/knot/i).waitFor(); // refused: 7 is not between the end knots
  await other.locator('.toast-error').getByRole('button', { name: 'Close' }).click();
  await other.keyboard.press('k');
  await other.getByLabel('Knot', { exact: true }).press('Enter');
  for (const each of [page, other]) {
    await each.waitForFunction(() => window.latticed.scene!.session.lattice.count === 80);
    await followsDefinition(each, OBJ);
  }
  await shot('viewer_second_window', other);
  assert.deepEqual(otherErrors, []);
  await other.close();
  await page.locator('.person').waitFor({ state: 'detached' });
});

test('the surface itself is pulled: what was pressed comes along to where the pointer goes', async () => {
  const [x, y] = await page.evaluate(() => {
    const { viewport, scene } = window.latticed;
    const { bounds } = scene!.session.surface;
    // The side of the torus near the camera.
    const away = viewport.rig.basis()[2];
    const [px, py] = viewport.project([away[0] * 1.1, away[1] * 1.1, bounds.max.z * 0.5])!;
    const box = viewport.canvas.getBoundingClientRect();
    return [box.left + px, box.top + py];
  });
  /** The point of the surface under a place of the page. */
  const picked = (px: number, py: number): Promise<Vec3 | undefined> =>
    page.evaluate(
      async ([u, v]) => {
        const { viewport, scene } = window.latticed;
        const { origin, direction } = viewport.ray(...viewport.place({ clientX: u, clientY: v }));
        return (await scene!.session.pick(origin, direction))?.position;
      },
      [px, py] as const,
    );
  const held = (await picked(x, y))!;

  await page.keyboard.press('p');
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= 8; ++step) await page.mouse.move(x - 5 * step, y + 4 * step); // the pick is still open
  await page.locator('.hint.running').getByText(/^Pull {2}\S+ {2}\S+ {2}\S+ {3}\(\S+\)$/).waitFor();
  await page.mouse.move(x - 41, y + 32);
  assert.ok(await page.locator('.pull-line').isHidden()); // nothing is out of reach
  await page.mouse.up();
  await page.keyboard.press('p');

  const target = await page.evaluate(
    ([p, dx, dy]) => {
      const { viewport } = window.latticed;
      const [right, up] = viewport.rig.basis();
      const { jacobian } = viewport.transformView(p, viewport.rig.basis(), viewport.rig.basis());
      const pixels = Math.hypot(...jacobian.map((row) => row[0] * right[0] + row[1] * right[1] + row[2] * right[2]));
      return [0, 1, 2].map((a) => p[a] + (right[a] * dx - up[a] * dy) / pixels) as unknown as Vec3;
    },
    [held, -41, 32] as const,
  );
  await until(async () => distance((await picked(x - 41, y + 32)) ?? held, target) < 0.02);
});

test('a lattice that was saved brings its shape back when it is dropped on the page', async () => {
  const before = await controlPoint(page, 0);
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Control+s')]);
  const json = (await saved(download)).toString();

  await page.evaluate(() => window.latticed.commands.get('reset').run());
  await page.waitForFunction(([x]) => window.latticed.scene!.session.lattice.points[2] !== x, [before[2]] as const);
  await dropFiles(page, [['lattice.json', json]]);
  await page.waitForFunction(([x]) => window.latticed.scene!.session.lattice.points[2] === x, [before[2]] as const);

  assert.equal(latticeFromJson(json).count, 80);
  await followsDefinition(page, OBJ);
});

test('a sample becomes a scene, whose upper plane R Z 4 5 turns about its middle', async () => {
  const { page: fresh, errors: freshErrors } = await openPage(browser, server.origin);
  await fresh.emulateMedia({ colorScheme: 'dark' });
  await fresh.setViewportSize({ width: 1200, height: 760 }); // the size of the README's picture
  await fresh.locator('[data-sample=knot]').click();
  await fresh.getByText('5,760 faces').waitFor();
  await fresh.getByRole('button', { name: 'Create scene' }).click();
  await live(fresh);
  await fresh.keyboard.press('n');
  const before = await controlPoint(fresh, CORNER);
  const opposite = await controlPoint(fresh, 48); // the opposite corner of the same plane

  await fresh.evaluate((corner) => window.latticed.scene!.editor.selection.select([corner]), CORNER);
  for (const key of ['Shift+W', 'r', 'z', '4', '5', 'Enter']) await fresh.keyboard.press(key);
  await fresh.keyboard.press('Home');

  const after = await controlPoint(fresh, CORNER);
  const [x, y] = [(before[0] - opposite[0]) / 2, (before[1] - opposite[1]) / 2]; // from the middle
  const turned: Vec3 = [
    (before[0] + opposite[0]) / 2 + Math.SQRT1_2 * (x - y),
    (before[1] + opposite[1]) / 2 + Math.SQRT1_2 * (x + y),
    before[2],
  ];
  assert.ok(distance(after, turned) < 1e-9, `${after} is not ${turned}`);
  await fresh.locator('[data-hud=updates]').getByText(/^0$/).waitFor(); // no more updates come
  await fresh.addStyleTag({ content: '.hud { display: none }' }); // its figures are of software drawing
  await shot('viewer', fresh);
  assert.deepEqual(freshErrors, []);
  await fresh.close();
});

test('the help lists the key of every command, and Escape closes it', async () => {
  await page.keyboard.press('?');

  const listed = await page.locator('.help dl kbd').allInnerTexts();
  const keys = await page.evaluate(() =>
    window.latticed.commands.list.flatMap(({ keys: k }) => (k === undefined ? [] : [k[0]])),
  );
  await shot('viewer_help');
  assert.deepEqual(keys.filter((key) => !listed.includes(key)), []);
  await page.keyboard.press('End'); // scrolls
  await page.waitForFunction(() => document.querySelector('.help-scroll')!.scrollTop > 0);
  await page.keyboard.press('Tab'); // moves the focus past the only button, out of the page
  await page.keyboard.press('h');
  assert.equal(await page.evaluate(() => window.latticed.scene!.editor.selection.hiddenCount), 0);
  await page.keyboard.press('Escape');
  await page.locator('.help').waitFor({ state: 'detached' });
});

test('a page that is opened after a restart of the server has the scene as it was, and did not fetch its mesh', async () => {
  const before = await controlPoint(page, 0);
  const address = page.url();

  await page.goto('about:blank');
  await server.kill();
  await server.restart();
  await page.goto(address);

  await live(page);
  await setView({ segments: 3 });
  assert.deepEqual(await controlPoint(page, 0), before);
  await followsDefinition(page, OBJ);
  assert.deepEqual(readBacks, []);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface in the viewer in Chromium: pulled where it can and where it cannot follow.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { latticeFromJson, latticeToJson } from '@src/lattice/lattice_json';
import { length, sub, type Vec3 } from '@src/lattice/vec';
import { launch, openPage } from './browser';
import { ServerProcess } from './server_process';
import { plainSheetObj } from './sheet';
import { createScene, dropFiles, frames, live, placeOf } from './viewer_page';

let server: ServerProcess;
let browser: Browser;
let page: Page;
let errors: string[];

async function shot(name: string): Promise<void> {
  if (process.env.LATTICED_SHOTS) await page.screenshot({ path: join(process.env.LATTICED_SHOTS, `${name}.png`) });
}

/** Looks from above at what is open, without its cage. */
async function lookFromAbove(): Promise<void> {
  await page.evaluate(() => {
    window.latticed.settings.set({ cage: false, gizmo: 'none', orthographic: true });
    window.latticed.viewport.rig.lookFrom([0, -1e-3, 1]);
    window.latticed.scene!.frameAll();
  });
  await frames(page);
}

/** Presses on the surface at a point of the world and moves by pixels. */
async function pull(from: Vec3, right: number, up: number): Promise<[number, number]> {
  const [x, y] = await placeOf(page, from);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + right, y - up, { steps: 4 });
  return [x, y];
}

/** The ends of the line to what is out of reach, in pixels of the page. */
function pullLine(): Promise<number[]> {
  return page.evaluate(() => {
    const line = document.querySelector('.pull-line line')!;
    const box = window.latticed.viewport.canvas.getBoundingClientRect();
    return ['x1', 'y1', 'x2', 'y2'].map((name, i) => Number(line.getAttribute(name)) + (i % 2 === 0 ? box.left : box.top));
  });
}

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_VIEWER!);
  browser = await launch();
  ({ page, errors } = await openPage(browser, server.origin));
  await page.setViewportSize({ width: 640, height: 480 });
});

after(async () => {
  await browser?.close();
  await server?.kill();
});

test('what lies outside the lattice is out of reach of a pull: a line and words say how far, until Escape', async () => {
  await dropFiles(page, [['sheet.obj', plainSheetObj()]]);
  await createScene(page);
  const whole = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  const vector = ([x, y, z]: Vec3): object => ({ x, y, z });
  const frame = { origin: vector([0, -1.2, -1]), u: vector([1.2, 0, 0]), v: vector([0, 2.4, 0]), w: vector([0, 0, 2]) }; // right half
  const half = latticeFromJson(JSON.stringify({ frame, size: { u: 3, v: 3, w: 3 }, degree: { u: 2, v: 2, w: 2 } }));
  await dropFiles(page, [['half.json', latticeToJson(half)]]);
  await page.waitForFunction((id) => window.latticed.scene!.session.sceneId !== id, whole);
  await live(page);
  await lookFromAbove();
  await page.keyboard.press('p');

  const [x, y] = await pull([-0.6, 0.1, 0], 60, 40);
  await page.locator('.hint.running').getByText(/^Pull .*\((\S+)\) +out of reach by \1: outside the lattice$/).waitFor();
  await page.mouse.move(x + 30, y - 40);
  await page.locator('.hint.running').getByText(/\((\S+)\) +out of reach by \1:/).waitFor();
  await frames(page);

  assert.ok(await page.locator('.pull-line').isVisible());
  (await pullLine()).forEach((at, i) => assert.ok(Math.abs(at - [x, y, x + 30, y - 40][i]) < 1, `${i}: ${at}`));
  assert.ok(await page.locator('.transform-bar').isHidden());
  await shot('viewer_out_of_reach');
  await page.keyboard.press('Escape');
  await page.locator('.pull-line').waitFor({ state: 'hidden' });
  assert.equal(await page.locator('.hint').innerText(), 'Press on the surface and pull it');
  await page.mouse.up();
});

test('what the lattice holds comes along with a pull: words say how far, and nothing is out of reach', async () => {
  const rest = await page.evaluate(() => [...window.latticed.scene!.session.lattice.points]);
  await page.evaluate(() => {
    const answered = new Promise((resolve) =>
      window.latticed.scene!.session.on('update', ({ msFromEdit }) => msFromEdit !== undefined && resolve(undefined)));
    Object.assign(window, { answered });
  });

  await pull([0.6, 0.1, 0], 40, 30);
  await page.evaluate(() => (window as unknown as { answered: Promise<unknown> }).answered);
  await frames(page);

  assert.match(await page.locator('.hint.running').innerText(), /^Pull {2}\S+ {2}\S+ {2}\S+ {3}\(\S+\)$/);
  assert.ok(await page.locator('.pull-line').isHidden());
  await page.mouse.up();
  assert.equal(await page.locator('.hint').innerText(), 'Press on the surface and pull it');
  const moved = await page.evaluate(() => [...window.latticed.scene!.session.lattice.points]);
  assert.ok(length(sub(moved.slice(39, 42) as unknown as Vec3, rest.slice(39, 42) as unknown as Vec3)) > 1e-3); // the middle
  await page.keyboard.press('p');
  assert.deepEqual(errors, []);
});

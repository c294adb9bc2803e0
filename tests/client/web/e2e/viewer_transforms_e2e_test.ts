// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Transforms in the viewer in Chromium: Blender's keys and the wheel, the handles, and a tablet's fingers.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, beforeEach, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { distance, length, sub, type Vec3 } from '@src/lattice/vec';
import { launch } from './browser';
import { ServerProcess } from './server_process';
import { torusObj } from './torus';
import { controlPoint, createScene, dropFiles, onScreen } from './viewer_page';

const CORNER = 63; // the last of 4 x 4 x 4 control points
const BESIDE = 62;

let server: ServerProcess;
let browser: Browser;
let page: Page;
let rest: Vec3;
const errors: string[] = [];

async function press(...keys: string[]): Promise<void> {
  for (const key of keys) await page.keyboard.press(key);
}

async function shot(name: string): Promise<void> {
  if (process.env.LATTICED_SHOTS) await page.screenshot({ path: join(process.env.LATTICED_SHOTS, `${name}.png`) });
}

function selectCorner(): Promise<void> {
  return page.evaluate((corner) => window.latticed.scene!.editor.selection.select([corner]), CORNER);
}

function selected(): Promise<number[]> {
  return page.evaluate(() => [...window.latticed.scene!.editor.selection.indices]);
}

/** A finger that goes from one place of the page to another. */
async function swipe(from: readonly [number, number], to: readonly [number, number]): Promise<void> {
  const session = await page.context().newCDPSession(page);
  const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', ...touchPoints: { x: number; y: number }[]) =>
    session.send('Input.dispatchTouchEvent', { type, touchPoints });
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  await touch('touchStart', { x: from[0], y: from[1] });
  for (let step = 1; step <= 8; ++step) await touch('touchMove', { x: from[0] + (dx * step) / 8, y: from[1] + (dy * step) / 8 });
  await touch('touchEnd');
  await session.detach();
}

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_VIEWER!);
  browser = await launch();
  const context = await browser.newContext({ viewport: { width: 640, height: 480 }, hasTouch: true });
  page = await context.newPage();
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(server.origin);
  await dropFiles(page, [['torus.obj', torusObj(12, 8)]]);
  await createScene(page);
  await page.evaluate(() => window.latticed.settings.set({ view: { ...window.latticed.settings.value.view, segments: 2 } })); // quick frames
  rest = await controlPoint(page, CORNER);
});

beforeEach(async () => {
  await page.evaluate(() => {
    window.latticed.settings.set({ toggling: false, gizmo: 'move', soft: { enabled: false, radius: 0.5, falloff: 'smooth' } });
    window.latticed.commands.get('reset').run();
  });
  await page.waitForFunction(([i, x, y, z]) => {
    const { points } = window.latticed.scene!.session.lattice;
    return points[3 * i] === x && points[3 * i + 1] === y && points[3 * i + 2] === z;
  }, [CORNER, ...rest] as const);
  await selectCorner();
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))); // handles
});

after(async () => {
  await browser?.close();
  await server?.kill();
});

test('G 1 Tab 2 Tab - . 5 Enter moves by three numbers', async () => {
  await press('g', '1', 'Tab', '2', 'Tab', '-', '.', '5', 'Enter');

  const there = await controlPoint(page, CORNER);
  assert.ok(distance(there, [rest[0] + 1, rest[1] + 2, rest[2] - 0.5]) < 1e-12, `${there} from ${rest}`);
  assert.equal(await page.evaluate(() => document.activeElement?.tagName), 'BODY'); // Tab went nowhere else
});

test('R R rolls the plane with the pointer: distances to the pivot stay', async () => {
  await press('Shift+W');
  const pivot = await page.evaluate(() => window.latticed.scene!.editor.pivot());
  await page.mouse.move(300, 200);

  await press('r', 'r');
  await page.mouse.move(380, 240);
  assert.match(await page.locator('.hint').innerText(), /^Trackball/);
  await press('Enter');

  const there = await controlPoint(page, CORNER);
  assert.ok(distance(there, rest) > 0.3, `${there} is where it was`);
  assert.ok(Math.abs(length(sub(there, pivot)) - length(sub(rest, pivot))) < 1e-9);
});

test('the wheel turns the reach of soft selection while a transform runs, and does not zoom', async () => {
  const distanceOfCamera = (): Promise<number> => page.evaluate(() => window.latticed.viewport.rig.camera.position.length());
  const [x, y] = await onScreen(page, CORNER);
  const far = await distanceOfCamera();
  await press('o');
  await page.mouse.move(x, y);
  await press('g', 'z', '1');
  const still = await controlPoint(page, BESIDE); // beyond the reach at first

  for (let i = 0; i < 9; ++i) await page.mouse.wheel(0, 100);
  await page.waitForFunction(() => Math.abs(window.latticed.settings.value.soft.radius - 0.5 * 1.1 ** 9) < 1e-9);
  const lifted = await controlPoint(page, BESIDE);
  assert.ok(lifted[2] > still[2] && lifted[2] < still[2] + 1, `${lifted} from ${still}`);
  assert.match(await page.locator('.hint').innerText(), /^Move\s+1/);
  await press('Escape');

  assert.deepEqual(await controlPoint(page, BESIDE), still);
  assert.equal(await distanceOfCamera(), far);
  await page.mouse.wheel(0, 100);
  await page.waitForFunction((was) => window.latticed.viewport.rig.camera.position.length() > was, far);
});

test('a handle moves along its axis; Escape and a right click let go of it without an effect', async () => {
  const tip = await page.evaluate(([px, py, pz]) => {
    const { viewport } = window.latticed;
    const [x, y] = viewport.project([px, py, pz])!;
    const [ux, uy] = viewport.project([px, py, pz + 0.1])!;
    const box = viewport.canvas.getBoundingClientRect();
    const along = (0.08 * box.height) / Math.hypot(ux - x, uy - y); // handles keep their size on the screen
    return [box.left + x + along * (ux - x), box.top + y + along * (uy - y)] as const;
  }, rest);
  const hold = async (): Promise<void> => {
    await page.mouse.move(...tip);
    await page.mouse.down();
    await page.mouse.move(tip[0], tip[1] - 40, { steps: 4 });
    const [, , z] = await controlPoint(page, CORNER);
    assert.ok(z > rest[2] + 0.05, `${z} from ${rest[2]}`);
  };
  const release = async (): Promise<void> => {
    await page.mouse.move(tip[0], tip[1] - 60, { steps: 2 });
    await page.mouse.up();
  };
  const clickRight = async (): Promise<void> => {
    await page.mouse.down({ button: 'right' });
    await page.mouse.up({ button: 'right' });
  };
  for (const letGo of [() => press('Escape'), clickRight]) {
    await hold();
    await letGo();
    await release();
    assert.deepEqual(await controlPoint(page, CORNER), rest);
    assert.deepEqual(await selected(), [CORNER]);
  }

  await hold();
  await release();
  const [x, y, z] = await controlPoint(page, CORNER);
  assert.ok(Math.hypot(x - rest[0], y - rest[1]) < 1e-9 && z > rest[2] + 0.05, `${[x, y, z]} from ${rest}`);
});

test('fingers select one by one, also below a handle, drag a point, and steer a transform that buttons end', async () => {
  await page.setViewportSize({ width: 1024, height: 768 });
  await page.locator('[data-command=toggling]').tap();
  await page.touchscreen.tap(...(await onScreen(page, BESIDE)));
  assert.deepEqual(await selected(), [BESIDE, CORNER]);
  await page.locator('[data-command=toggling]').tap();

  const [x, y] = await onScreen(page, 0);
  await swipe([x, y], [x + 40, y - 20]);
  const [nowX, nowY] = await onScreen(page, 0);
  assert.ok(Math.hypot(nowX - x - 40, nowY - y + 20) < 2, `${[nowX - x, nowY - y]} is not 40, -20`);

  await selectCorner();
  await page.getByRole('button', { name: 'Transform', exact: true }).tap();
  await page.getByRole('menuitem', { name: 'Move G' }).tap();
  await swipe([400, 400], [440, 340]);
  assert.ok(distance(await controlPoint(page, CORNER), rest) > 0.1);
  await page.getByRole('button', { name: 'Z', exact: true }).tap();
  await page.getByLabel('Amount').fill('-0.25');
  await shot('viewer_tablet');
  assert.deepEqual(await controlPoint(page, CORNER), [rest[0], rest[1], rest[2] - 0.25]);
  await page.getByRole('button', { name: 'Cancel' }).tap();
  assert.deepEqual(await controlPoint(page, CORNER), rest);
  await page.locator('.transform-bar').waitFor({ state: 'hidden' });
  assert.deepEqual(errors, []);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Transforms in the viewer in Chromium: Blender's keys and the wheel, the handles, and a tablet's fingers.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, beforeEach, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { add, distance, length, scale, sub, type Vec3 } from '@src/lattice/vec';
import { launch } from './browser';
import { ServerProcess } from './server_process';
import { torusObj } from './torus';
import { controlPoint, createScene, dropFiles, frames, onScreen, placeOf } from './viewer_page';

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

function select(...indices: number[]): Promise<void> {
  return page.evaluate((list) => window.latticed.scene!.editor.selection.select(list), indices);
}

/** Waits until a control point is at a place, as the server says. */
async function comesTo(index: number, place: Vec3): Promise<void> {
  await page.waitForFunction(([i, x, y, z]) => {
    const { points } = window.latticed.scene!.session.lattice;
    return Math.hypot(points[3 * i] - x, points[3 * i + 1] - y, points[3 * i + 2] - z) < 1e-9;
  }, [index, ...place] as const);
}

function assertNear(got: Vec3, wanted: Vec3, most = 1e-9): void {
  assert.ok(distance(got, wanted) < most, `${got} is not ${wanted}`);
}

/** Whether a number is a multiple of a step, but not none of it. */
function isStepped(x: number, step: number): boolean {
  return Math.abs(x) > step / 2 && Math.abs(x / step - Math.round(x / step)) < 1e-6;
}

function selected(): Promise<number[]> {
  return page.evaluate(() => [...window.latticed.scene!.editor.selection.indices]);
}

/** A finger that goes from one place of the page to another, and rests there: Chromium drops a tap soon after a fling. */
async function swipe(from: readonly [number, number], to: readonly [number, number]): Promise<void> {
  const session = await page.context().newCDPSession(page);
  const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', ...touchPoints: { x: number; y: number }[]) =>
    session.send('Input.dispatchTouchEvent', { type, touchPoints });
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  await touch('touchStart', { x: from[0], y: from[1] });
  for (let step = 1; step <= 8; ++step) await touch('touchMove', { x: from[0] + (dx * step) / 8, y: from[1] + (dy * step) / 8 });
  await page.waitForTimeout(100);
  await touch('touchMove', { x: to[0], y: to[1] });
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
    window.latticed.settings.set({
      toggling: false, gizmo: 'move', orientation: 'world', pivot: 'median', mirror: [false, false, false],
      soft: { enabled: false, radius: 0.5, falloff: 'smooth' },
    });
    window.latticed.commands.get('reset').run();
  });
  await comesTo(CORNER, rest);
  await select(CORNER);
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await frames(page); // handles
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

test('Ctrl-Shift-Z and Ctrl-Y do again what Ctrl-Z took back, until something else is done', async () => {
  const moved = add(rest, [0, 0, 1]);
  await press('g', 'z', '1', 'Enter');
  for (const redo of ['Control+Shift+Z', 'Control+y']) {
    await press('Control+z');
    await comesTo(CORNER, rest);
    await press(redo);
    await comesTo(CORNER, moved);
  }

  await press('Control+z');
  await comesTo(CORNER, rest);
  await press('g', 'x', '2', 'Enter', 'Control+y');
  await page.locator('.toast:not(.toast-error)').getByText('There is nothing to redo.').waitFor();
  assertNear(await controlPoint(page, CORNER), add(rest, [2, 0, 0]));
  await press('Control+z');
  await comesTo(CORNER, rest);
});

test('a dragged point snaps with Ctrl, and with Shift goes a tenth of the way', async () => {
  await page.evaluate(() => window.latticed.settings.set({ gizmo: 'none' }));
  const [x, y] = await onScreen(page, CORNER);
  const step = await page.evaluate(([px, py, pz]) => {
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] as const;
    return window.latticed.viewport.transformView([px, py, pz], axes, axes).snapStep;
  }, rest);
  const dragWith = async (key: string): Promise<Vec3> => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.keyboard.down(key);
    await page.mouse.move(x - 120, y + 70, { steps: 4 });
    const way = sub(await controlPoint(page, CORNER), rest);
    await page.keyboard.up(key);
    await press('Escape');
    await page.mouse.up();
    return way;
  };

  const free = await dragWith('a'); // which means nothing
  const snapped = await dragWith('Control');
  const fine = await dragWith('Shift');

  assert.ok(!free.every((way) => isStepped(way, step)), `${free}`);
  snapped.forEach((way, axis) => {
    assert.ok(Math.abs(way - Math.round(free[axis] / step) * step) < 1e-9, `${snapped} is not ${free} in steps of ${step}`);
  });
  assertNear(fine, scale(free, 0.1), 1e-6);
  assertNear(await controlPoint(page, CORNER), rest);
});

test('. takes the active point or each as the pivot, S 2 scales about it, and Alt-U does the same on the other side', async () => {
  const beside = await controlPoint(page, BESIDE);
  const across = await controlPoint(page, 60); // of the same row along u, 60 to 63
  await select(BESIDE, CORNER); // the active one is the last

  await press('s', '2', 'Enter');
  const middle = scale(add(rest, beside), 0.5);
  assertNear(await controlPoint(page, CORNER), add(middle, scale(sub(rest, middle), 2)));
  assertNear(await controlPoint(page, BESIDE), add(middle, scale(sub(beside, middle), 2)));
  await press('Control+z');
  await comesTo(CORNER, rest);

  await press('.', 'r', 'z', '9', '0', 'Enter');
  assert.equal(await page.evaluate(() => window.latticed.settings.value.pivot), 'active');
  assertNear(await controlPoint(page, CORNER), rest);
  assertNear(await controlPoint(page, BESIDE), [rest[0], rest[1] - (rest[0] - beside[0]), rest[2]]);
  await press('Control+z');
  await comesTo(BESIDE, beside);

  await press('.', 's', '2', 'Enter'); // each about itself stays
  assert.equal(await page.evaluate(() => window.latticed.settings.value.pivot), 'each');
  assertNear(await controlPoint(page, BESIDE), beside);

  await select(CORNER);
  await press('Alt+u', 'g', '1', 'Tab', '.', '5', 'Enter');
  assertNear(await controlPoint(page, CORNER), add(rest, [1, 0.5, 0]));
  assertNear(await controlPoint(page, 60), add(across, [-1, 0.5, 0]));
});

test('the axes of the view are those of the camera', async () => {
  await press(',', ',');
  assert.equal(await page.evaluate(() => window.latticed.settings.value.orientation), 'view');

  await press('g', 'x', '1', 'Enter');

  const [right] = await page.evaluate(() => window.latticed.viewport.rig.basis());
  assertNear(await controlPoint(page, CORNER), add(rest, right));
});

test('handles turn and scale about the pivot, with Ctrl in steps', async () => {
  const beside = await controlPoint(page, BESIDE);
  const pivot = scale(add(rest, beside), 0.5);
  /** Drags a handle with Ctrl from so far from the pivot, in heights of the view, along a direction of the world. */
  const dragHandle = async (gizmo: 'rotate' | 'scale', along: Vec3, heights: number, way: readonly [number, number]): Promise<void> => {
    await page.evaluate((kind) => window.latticed.settings.set({ gizmo: kind }), gizmo);
    await frames(page);
    const { height } = (await page.locator('canvas').boundingBox())!;
    const [x, y] = await placeOf(page, pivot);
    const [ux, uy] = await placeOf(page, add(pivot, scale(along, 0.1)));
    const unit = await page.evaluate(([px, py, pz]) => window.latticed.viewport.disc([px, py, pz], 0.1)!.radius, pivot);
    const from = [x + ((ux - x) * heights * height) / unit, y + ((uy - y) * heights * height) / unit] as const;
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.keyboard.down('Control');
    await page.mouse.move(from[0] + way[0], from[1] + way[1], { steps: 3 });
    await page.mouse.up();
    await page.keyboard.up('Control');
  };
  await select(BESIDE, CORNER);
  const view = await page.evaluate(() => window.latticed.viewport.rig.basis()[2]);

  // The ring around Z, where it is nearest.
  await dragHandle('rotate', scale([view[0], view[1], 0], 1 / Math.hypot(view[0], view[1])), 0.107, [37, 0]);
  const [dx, dy, dz] = sub(await controlPoint(page, CORNER), pivot);
  const degrees = (Math.atan2(dy, dx) * 180) / Math.PI;
  assert.ok(isStepped(degrees, 5) && Math.abs(dz) < 1e-9, `${[dx, dy, dz]}`);
  assert.ok(Math.abs(Math.hypot(dx, dy) - distance(rest, pivot)) < 1e-9);
  assertNear(await controlPoint(page, BESIDE), sub(pivot, [dx, dy, dz]));
  await press('Control+z');
  await comesTo(CORNER, rest);

  await dragHandle('scale', [1, 0, 0], 0.08, [37, -20]);
  const factor = ((await controlPoint(page, CORNER))[0] - pivot[0]) / (rest[0] - pivot[0]);
  assert.ok(isStepped(factor, 0.1) && Math.abs(factor - 1) > 0.05, `${factor}`);
  assertNear(await controlPoint(page, CORNER), [pivot[0] + factor * (rest[0] - pivot[0]), rest[1], rest[2]]);
  assertNear(await controlPoint(page, BESIDE), [pivot[0] + factor * (beside[0] - pivot[0]), beside[1], beside[2]]);
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

  await select(CORNER);
  await page.getByRole('button', { name: 'Transform', exact: true }).tap();
  await page.getByRole('menuitem', { name: 'Move G' }).tap();
  await page.locator('.transform-bar').waitFor();
  await swipe([400, 400], [440, 340]);
  assert.ok(distance(await controlPoint(page, CORNER), rest) > 0.1);
  // Clicks come some time after the fingers that make them.
  await page.getByRole('button', { name: 'Z', exact: true }).tap();
  await page.getByRole('button', { name: 'Z', exact: true, pressed: true }).waitFor();
  await page.getByLabel('Amount').fill('-0.25');
  await shot('viewer_tablet');
  assert.deepEqual(await controlPoint(page, CORNER), [rest[0], rest[1], rest[2] - 0.25]);
  await page.getByRole('button', { name: 'Cancel' }).tap();
  await page.locator('.transform-bar').waitFor({ state: 'hidden' });
  assert.deepEqual(await controlPoint(page, CORNER), rest);
});

test('on a tablet every command is in a menu, and nothing lies above the buttons of a transform', async () => {
  await page.setViewportSize({ width: 768, height: 1024 });
  const listed: string[] = [];
  for (const menu of ['File', 'Edit', 'Select', 'Transform', 'View']) {
    await page.locator('.menu-button').getByText(menu, { exact: true }).tap();
    await page.getByRole('button', { name: menu, exact: true, expanded: true }).waitFor();
    listed.push(...(await page.locator('.menu button > span').allInnerTexts()));
  }
  assert.deepEqual(listed, await page.evaluate(() => window.latticed.commands.list.map(({ label }) => label)));
  await press('Escape');

  await page.locator('[data-command=panel]').tap();
  await page.evaluate(() => window.latticed.toasts.fail('A file of a name that is so long that it takes lines is no mesh that the server reads.'));
  await page.getByRole('button', { name: 'Transform', exact: true }).tap();
  await page.getByRole('menuitem', { name: 'Rotate R' }).tap();
  await shot('viewer_tablet_upright');
  for (const button of await page.locator('.transform-bar > *').all()) await button.click({ trial: true });
  await page.getByRole('button', { name: 'Cancel' }).tap();
  assert.deepEqual(errors, []);
});

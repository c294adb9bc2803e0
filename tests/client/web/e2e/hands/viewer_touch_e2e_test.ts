// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium on a tablet: fingers, and small screens.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { add, distance, scale, sub, type Vec3 } from '@src/lattice/vec';
import { swipe, type Place } from './fingers';
import { allPoints, CORNER, errors, openTorus, page, pointAtServer, select, selected, shot, until, useStage } from '../support/stage';
import { camera, controlPoint, frames, onScreen, placeOf, upperHandle } from '../support/viewer_page';

const BESIDE = 62;
const EMPTY: Place = [80, 430]; // an empty place of the view

let rest: Vec3;
let points: number[]; // at rest

async function distanceOfCamera(): Promise<number> {
  const { position, target } = await camera(page);
  return distance(position, target);
}

function shifted([x, y]: Place, dx: number, dy: number): Place {
  return [x + dx, y + dy];
}

/** The move in the plane across Z, from the corner at rest, that matches a finger's move on the screen. */
async function wayAcrossZ(right: number, down: number): Promise<Vec3> {
  const pixelsAlong = async (unit: Vec3): Promise<[number, number]> => {
    const step = 1e-3;
    const [ax, ay] = await placeOf(page, sub(rest, scale(unit, step)));
    const [bx, by] = await placeOf(page, add(rest, scale(unit, step)));
    return [(bx - ax) / (2 * step), (by - ay) / (2 * step)];
  };
  const [xRight, xDown] = await pixelsAlong([1, 0, 0]);
  const [yRight, yDown] = await pixelsAlong([0, 1, 0]);
  const area = xRight * yDown - yRight * xDown;
  return [(right * yDown - yRight * down) / area, (xRight * down - right * xDown) / area, 0];
}

/** Taps a button of the running transform, and waits until it shows that it is on or off. */
async function tapSwitch(name: string, pressed: boolean): Promise<void> {
  await page.getByRole('button', { name, exact: true }).tap();
  await page.getByRole('button', { name, exact: true, pressed }).waitFor();
}

useStage({
  context: { viewport: { width: 640, height: 480 }, hasTouch: true },
  begin: async () => {
    await openTorus();
    rest = await controlPoint(page, CORNER);
    points = await allPoints();
  },
});

beforeEach(async () => {
  await page.evaluate(() => {
    const { scene, settings, viewport, commands } = window.latticed;
    settings.set({ toggling: false, gizmo: 'move', orientation: 'world', pivot: 'median' });
    commands.get('reset').run();
    viewport.rig.lookFrom([3, -4, 2.4]);
    scene!.editor.selection.select([63]);
    scene!.frameAll();
  });
  await page.waitForFunction(
    (at) => window.latticed.scene!.session.lattice.points.every((x, i) => Math.abs(x - at[i]) < 1e-9), points);
  await frames(page); // draws the handles
});

test('one finger turns the view, two shift it, and a pinch zooms; neither points nor the selection change', async () => {
  const before = await camera(page);

  await swipe(page, [[EMPTY, shifted(EMPTY, 80, -30)]]);
  const turned = await camera(page);
  assert.ok(distance(turned.basis[2], before.basis[2]) > 0.2);
  assert.ok(distance(turned.target, before.target) < 1e-9);

  const [x, y] = await placeOf(page, turned.target);
  await swipe(page, [[EMPTY, shifted(EMPTY, 40, -30)], [shifted(EMPTY, 60, 0), shifted(EMPTY, 100, -30)]]);
  const [nowX, nowY] = await placeOf(page, turned.target);
  assert.ok(Math.hypot(nowX - x - 40, nowY - y + 30) < 6, `${[nowX - x, nowY - y]} is not 40, -30`);
  assert.ok(distance((await camera(page)).basis[2], turned.basis[2]) < 1e-6);

  const far = await distanceOfCamera();
  await swipe(page, [[EMPTY, shifted(EMPTY, -40, 0)], [shifted(EMPTY, 80, 0), shifted(EMPTY, 120, 0)]]);
  const zoomed = far / (await distanceOfCamera());
  assert.ok(Math.abs(zoomed - 2) < 0.1, `${zoomed}`); // the fingers' distance from each other doubles
  assert.deepEqual(await allPoints(), points);
  assert.deepEqual(await selected(), [CORNER]);
});

test('a handle that a finger drags moves the point along its axis', async () => {
  const tip = await upperHandle(page, rest);

  await swipe(page, [[tip, shifted(tip, 0, -60)]]);

  const [x, y, z] = await controlPoint(page, CORNER);
  assert.ok(Math.hypot(x - rest[0], y - rest[1]) < 1e-9 && z > rest[2] + 0.1, `${[x, y, z]} from ${rest}`);
  assert.deepEqual(await selected(), [CORNER]);
});

for (const what of ['a point', 'a handle']) {
  test(`a second finger makes it the camera's, also when the first is on ${what} and has moved it`, async () => {
    const first: Place = what === 'a point' ? await onScreen(page, 0) : await upperHandle(page, rest);
    const second = shifted(first, 50, 20);
    const from = await placeOf(page, [0, 0, 0]);

    await swipe(page, [[first, shifted(first, 32, 24)], [second, shifted(second, 32, 24)]], 0.5);

    assert.deepEqual(await allPoints(), points);
    assert.deepEqual(await selected(), what === 'a point' ? [0] : [CORNER]);
    const [x, y] = await placeOf(page, [0, 0, 0]);
    assert.ok(Math.hypot(x - from[0], y - from[1]) > 15, `${[x - from[0], y - from[1]]}`);

    // The next finger drags as usual.
    const [px, py] = await onScreen(page, 0);
    await swipe(page, [[[px, py], [px + 40, py - 20]]]);
    const [nowX, nowY] = await onScreen(page, 0);
    assert.ok(Math.hypot(nowX - px - 40, nowY - py + 20) < 2, `${[nowX - px, nowY - py]} is not 40, -20`);
  });
}

test('fingers select one by one, also below a handle, drag a point, and steer a transform that buttons end', async () => {
  await page.setViewportSize({ width: 1024, height: 768 });
  await page.locator('[data-command=toggling]').tap();
  await page.locator('[data-command=toggling][aria-pressed=true]').waitFor();
  await page.touchscreen.tap(...(await onScreen(page, BESIDE)));
  assert.deepEqual(await selected(), [BESIDE, CORNER]);
  await page.locator('[data-command=toggling]').tap();
  await page.locator('[data-command=toggling][aria-pressed=false]').waitFor();

  const [x, y] = await onScreen(page, 0);
  await swipe(page, [[[x, y], [x + 40, y - 20]]]);
  const [nowX, nowY] = await onScreen(page, 0);
  assert.ok(Math.hypot(nowX - x - 40, nowY - y + 20) < 2, `${[nowX - x, nowY - y]} is not 40, -20`);

  await select(CORNER);
  await page.getByRole('button', { name: 'Transform', exact: true }).tap();
  await page.getByRole('menuitem', { name: 'Move G' }).tap();
  await page.locator('.transform-bar').waitFor();
  await swipe(page, [[[400, 400], [440, 340]]]);
  assert.ok(distance(await controlPoint(page, CORNER), rest) > 0.1);
  // A click comes some time after its tap.
  await page.getByRole('button', { name: 'Z', exact: true }).tap();
  await page.getByRole('button', { name: 'Z', exact: true, pressed: true }).waitFor();
  const amount = page.getByLabel('Amount');
  await amount.fill('-0.25');
  const up = async (): Promise<number> => (await controlPoint(page, CORNER))[2] - rest[2];
  assert.deepEqual(await controlPoint(page, CORNER), [rest[0], rest[1], rest[2] - 0.25]);

  for (const [text, by, shown] of [['1/2', 0.5, '0.5'], ['+=0.1', 0.6, '0.6'], ['pi*2', 2 * Math.PI, '6.283185307'], ['1e-7', 1e-7, '0.0000001']] as const) {
    await amount.fill(text);
    assert.ok(Math.abs(await up() - by) < 1e-8, `${text}: ${await up()}`);
    await amount.press('Enter');
    assert.equal(await amount.inputValue(), shown);
  }
  await amount.fill('1/2 apples');
  assert.equal(await page.locator('.transform-bar .why').textContent(), '“apples” is not understood here.');
  assert.ok(Math.abs(await up()) < 1e-6, 'a wrong one changes nothing');
  await shot('viewer_tablet');
  await amount.fill('');
  assert.equal(await page.locator('.transform-bar .why').textContent(), '');
  await page.getByRole('button', { name: 'Cancel' }).tap();
  await page.locator('.transform-bar').waitFor({ state: 'hidden' });
  assert.deepEqual(await controlPoint(page, CORNER), rest);
});

test('buttons keep a move to a plane, make it fine, snap it and confirm it, and the server has its lattice', async () => {
  await page.setViewportSize({ width: 1024, height: 768 });
  const step = await page.evaluate(([x, y, z]) => {
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] as const;
    return window.latticed.viewport.transformView([x, y, z], axes, axes).snapStep;
  }, rest);
  const way = await wayAcrossZ(56, 32);
  const swiped = async (): Promise<Vec3> => {
    await swipe(page, [[[400, 400], [456, 432]]]);
    return sub(await controlPoint(page, CORNER), rest);
  };
  const assertWay = (got: Vec3, wanted: Vec3): void => assert.ok(distance(got, wanted) < 1e-4, `${got} is not ${wanted}`);
  await page.getByRole('button', { name: 'Transform', exact: true }).tap();
  await page.getByRole('menuitem', { name: 'Move G' }).tap();
  await page.locator('.transform-bar').waitFor();

  await tapSwitch('Plane', true);
  await tapSwitch('Z', true);
  assertWay(await swiped(), way);
  await tapSwitch('Fine', true);
  assertWay(await swiped(), scale(way, 1.1));
  await tapSwitch('Fine', false);
  await tapSwitch('Snap', true);
  const snapped = scale(way, 2.1).map((x) => Math.round(x / step) * step) as unknown as Vec3;
  assertWay(await swiped(), snapped);
  assert.ok(distance(snapped, scale(way, 2.1)) > 1e-3, 'it is on a step by itself');
  await page.getByRole('button', { name: 'Confirm' }).tap();
  await page.locator('.transform-bar').waitFor({ state: 'hidden' });

  const there = await controlPoint(page, CORNER);
  await until(async () => String(await pointAtServer(CORNER)) === String(there));
  assertWay(sub(there, rest), snapped);
});

test('on a tablet the help scrolls below its button, and an edge glows where there is more', async () => {
  await page.setViewportSize({ width: 1024, height: 768 });
  await page.locator('[data-command=help]').tap();
  const content = page.locator('.help-scroll');
  const { x, y, width, height } = (await content.boundingBox())!;
  assert.ok(await content.evaluate((element) => element.scrollHeight > element.clientHeight + 20));
  await shot('viewer_tablet_help');

  await swipe(page, [[[x + width / 2, y + height - 40], [x + width / 2, y + 40]]]);
  await page.waitForFunction(() => {
    const { scrollTop, scrollHeight, clientHeight } = document.querySelector('.help-scroll')!;
    return scrollTop + clientHeight >= scrollHeight - 1;
  });
  await page.getByRole('button', { name: 'Close' }).tap();
  await page.locator('.help').waitFor({ state: 'detached' });
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
  await page.keyboard.press('Escape');

  await page.locator('[data-command=panel]').tap();
  await page.evaluate(() => window.latticed.toasts.fail('A file of a name that is so long that it takes lines is no mesh that the server reads.'));
  await page.getByRole('button', { name: 'Transform', exact: true }).tap();
  await page.getByRole('menuitem', { name: 'Rotate R' }).tap();
  await shot('viewer_tablet_upright');
  for (const button of await page.locator('.transform-bar > *').all()) await button.click({ trial: true });
  await page.getByRole('button', { name: 'Cancel' }).tap();
  assert.deepEqual(errors, []);
});

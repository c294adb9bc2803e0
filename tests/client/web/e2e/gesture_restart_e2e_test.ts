// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server that keeps nothing is killed in the middle of what a person does with the mouse, and started again.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import type { Page } from 'playwright-core';
import { allHave, keeps, keepToasts, shownBy, stageOfFile, toldOf, whoRestored } from './restarts';
import { torusObj } from './torus';
import { controlPoint, createScene, dropFiles, frames, onScreen, placeOf } from './viewer_page';

const OBJ = torusObj(12, 8);
const CORNER = 63; // the last of 4 x 4 x 4 control points
const LET_GO = 'The server was restarted, so what was being moved was let go where it was.';

const stage = stageOfFile();
let page: Page;
let scene: string;

beforeEach(async () => {
  await page?.close();
  page = await stage.browser.newPage({ viewport: { width: 640, height: 480 } });
  await page.goto(stage.server.origin);
  await dropFiles(page, [['torus.obj', OBJ]]);
  await createScene(page);
  scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  await page.evaluate(() => {
    window.latticed.settings.set({ gizmo: 'none' });
    window.latticed.scene!.session.setView({ segments: 2 }); // few points: one processor draws all
  });
  await keeps(page);
  await keepToasts(page);
  await frames(page);
});

/** Kills the server, and waits until the page has seen it. */
async function powerCut(): Promise<void> {
  await stage.server.kill();
  await page.locator('.connection[data-state=retrying]').waitFor();
}

/** Starts the server again, and waits until the page has restored its scene and let go of what was moved. */
async function powerBack(): Promise<void> {
  await stage.server.restart();
  assert.equal(await whoRestored(page), 'this browser');
  await toldOf(page, LET_GO);
  await page.locator('.connection[data-state=restored]').waitFor();
  assert.equal(await page.locator('.hint.running').count(), 0);
}

/** Waits until a coordinate of the server's control points is another than it was. */
async function serverFollows(index: number, from: number): Promise<void> {
  for (const end = Date.now() + 60_000; ; await page.waitForTimeout(20)) {
    const { lattice } = await stage.direct.scenes.getLattice({ scene });
    if (lattice!.controlPoints[index] !== from) return;
    assert.ok(Date.now() < end, `the server has ${from} still`);
  }
}

/** Of this run of the server there is nothing to take back. */
async function hasNothingToUndo(): Promise<void> {
  await page.keyboard.press('Control+z');
  await toldOf(page, '^There is nothing to undo\\.');
}

/** Another move goes from where all is, by as much as is typed. */
async function goesOnFrom(points: readonly number[]): Promise<void> {
  await page.evaluate((index) => window.latticed.scene!.editor.selection.select([index]), CORNER);
  for (const key of ['g', 'z', '1', 'Enter']) await page.keyboard.press(key);
  const moved = points.map((value, i) => (i === 3 * CORNER + 2 ? value + 1 : value));
  await allHave(stage.direct, scene, [page], moved, OBJ);
  await page.keyboard.press('Control+z');
  await allHave(stage.direct, scene, [page], points, OBJ);
}

test('a move by G whose server is killed goes on in the cage, and is let go once where it was when the server is back', async () => {
  const rest = await shownBy(page);
  const [x, y] = await onScreen(page, CORNER);
  await page.evaluate((index) => window.latticed.scene!.editor.selection.select([index]), CORNER);
  await page.mouse.move(x, y);
  await page.keyboard.press('g');
  await page.mouse.move(x - 20, y + 10, { steps: 4 });
  await serverFollows(3 * CORNER, rest[3 * CORNER]);

  await page.mouse.move(x - 40, y + 20, { steps: 4 }); // some of these are on their way
  await powerCut();
  const cut = await controlPoint(page, CORNER);
  await page.mouse.move(x - 60, y + 30, { steps: 4 });
  const there = await controlPoint(page, CORNER);
  assert.notDeepEqual(there, cut); // the cage answers without a server
  const moved = rest.map((value, i) => (i >= 3 * CORNER ? there[i - 3 * CORNER] : value));
  await powerBack();

  await page.mouse.move(x - 100, y + 80, { steps: 4 });
  await page.keyboard.press('Enter');
  await page.mouse.click(20, 460);
  await allHave(stage.direct, scene, [page], moved, OBJ);
  const [shownX, shownY] = await onScreen(page, CORNER);
  assert.ok(Math.hypot(shownX - (x - 60), shownY - (y + 30)) < 1, `${[shownX, shownY]}, where the pointer was at ${[x - 60, y + 30]}`);
  await hasNothingToUndo();
  await goesOnFrom(moved);
});

test('a move by G that goes on while the server comes back is let go at one place of its way', async () => {
  const rest = await shownBy(page);
  const [x, y] = await onScreen(page, CORNER);
  await page.evaluate((index) => window.latticed.scene!.editor.selection.select([index]), CORNER);
  await page.mouse.move(x, y);
  await page.keyboard.press('g');
  let step = 0;
  let isBack = false;
  const moving = (async () => {
    for (; !isBack; await page.waitForTimeout(8)) await page.mouse.move(x - 60 * ((++step % 100) / 100), y + 30 * ((step % 100) / 100));
  })();
  await serverFollows(3 * CORNER, rest[3 * CORNER]);
  await powerCut();
  await powerBack();
  isBack = true;
  await moving;

  const there = await shownBy(page);
  await allHave(stage.direct, scene, [page], there, OBJ);
  assert.deepEqual(there.slice(0, 3 * CORNER), rest.slice(0, 3 * CORNER)); // what the scene was made again without is sent
  const [shownX, shownY] = await onScreen(page, CORNER);
  const along = (x - shownX) / 60;
  assert.ok(along > -0.02 && along < 1.02 && Math.abs(shownY - (y + 30 * along)) < 1, `${[shownX, shownY]} from ${[x, y]}`);
  await goesOnFrom(there);
});

test('a pull of the surface whose server is killed ends with a word where the server left it, and the next one goes', async () => {
  const rest = await shownBy(page);
  const held = [0, -1.4, 0] as const; // of the torus, towards the viewer
  const middle = 3 * 21 + 1; // y of a control point near by, which comes along
  await page.keyboard.press('p');
  const [x, y] = await placeOf(page, held);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - 30, y + 20, { steps: 4 });
  await page.locator('.hint.running').waitFor();
  await page.waitForFunction(([index, from]) => window.latticed.scene!.session.lattice.points[index] !== from, [middle, rest[middle]] as const);

  await page.mouse.move(x - 40, y + 30, { steps: 4 }); // some of these are on their way
  await powerCut();
  const left = await shownBy(page);
  await page.mouse.move(x - 80, y + 60, { steps: 4 }); // only a server could say where to
  assert.deepEqual(await shownBy(page), left);
  await powerBack();
  await page.mouse.move(x - 120, y + 90, { steps: 4 });
  await page.mouse.up();
  await allHave(stage.direct, scene, [page], left, OBJ);

  const [againX, againY] = await placeOf(page, held);
  await page.mouse.move(againX, againY);
  await page.mouse.down();
  await page.mouse.move(againX + 20, againY - 10, { steps: 4 });
  await page.waitForFunction(([index, from]) => window.latticed.scene!.session.lattice.points[index] !== from, [middle, left[middle]] as const);
  await page.mouse.up();
  await page.keyboard.press('Control+z');
  await allHave(stage.direct, scene, [page], left, OBJ);
  await hasNothingToUndo();
  await page.keyboard.press('p');
  await goesOnFrom(left);
});

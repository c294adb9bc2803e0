// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Several windows on one scene. They may be more than the six HTTP/1.1 connections that a browser opens to a server.
// After the server is killed and started again, all go on.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import type { BrowserContext, Page } from 'playwright-core';
import { randomId } from '@src/wire/ids';
import { uploadMesh } from '@src/wire/upload';
import { stopWebSockets } from '../support/browser';
import { followsDefinition } from '../support/definition';
import { keepToasts, withData } from '../support/restarts';
import { allPoints, browser, CORNER, direct, OBJ, openTorus, page, press, select, server, until, useStage } from '../support/stage';
import { controlPoint, frames, live, onScreen } from '../support/viewer_page';

let scene: string;

/** A context that shares nothing with others, like another browser. */
async function openContext(t: TestContext): Promise<BrowserContext> {
  const context = await browser.newContext({ viewport: { width: 320, height: 240 } });
  t.after(() => context.close());
  return context;
}

async function openWindow(context: BrowserContext): Promise<Page> {
  const window = await context.newPage();
  await window.goto(`${server.origin}/?scene=${scene}`, { waitUntil: 'commit' });
  return window;
}

async function openWindows(context: BrowserContext, count: number): Promise<Page[]> {
  const windows = await Promise.all(Array.from({ length: count }, () => openWindow(context)));
  await Promise.all(windows.map((window) => live(window)));
  return windows;
}

/** The scene's control points at the server. */
async function controlPoints(): Promise<number[]> {
  return (await direct.scenes.getLattice({ scene })).lattice!.controlPoints;
}

/** Moves a control point down by quarters, which add up without rounding, and updates `expected`. */
async function move(of: Page, index: number, quarters: number, expected: number[]): Promise<void> {
  expected[3 * index + 2] -= quarters / 4;
  await of.evaluate(
    ([i, n]) => window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(i), offset: [0, 0, -n / 4] }),
    [index, quarters] as const);
}

/** Waits until the server and all windows have these control points, and the last window's surface follows them. */
async function allHave(windows: readonly Page[], expected: readonly number[]): Promise<void> {
  await until(async () => String(await controlPoints()) === String(expected));
  for (const each of windows) {
    await each.waitForFunction((all) => String(window.latticed.scene!.session.lattice.points) === all, String(expected));
  }
  await followsDefinition(windows.at(-1)!, OBJ);
}

/** The point of the surface straight below a place, if any. */
function pickBelow(of: Page, x: number, y: number): Promise<readonly number[] | undefined> {
  return of.evaluate(async (from) => (await window.latticed.scene!.session.pick([...from, 10], [0, 0, -1]))?.position, [x, y] as const);
}

useStage({
  serverOptions: withData(),
  context: { viewport: { width: 640, height: 480 } },
  begin: async () => {
    const mesh = await uploadMesh(direct, { format: MeshFormat.OBJ }, new Blob([OBJ]));
    // Few points, because the windows share a processor, which also draws.
    scene = (await direct.scenes.createScene({ mesh: mesh.id, sceneId: randomId(), defaultView: { segments: 2 } })).id;
  },
});

test('eight windows of one browser edit and pick at once: all have one lattice, and the surface that the definition says', async (t) => {
  const windows = await openWindows(await openContext(t), 8);
  const expected = await controlPoints();

  await Promise.all(windows.map(async (window, i) => {
    await move(window, 5 * i, 1, expected);
    const [x, y] = [Math.cos((Math.PI * i) / 4), Math.sin((Math.PI * i) / 4)]; // onto the middle of the tube
    const [hitX, hitY] = (await pickBelow(window, x, y))!;
    assert.ok(Math.hypot(hitX - x, hitY - y) < 1e-9, `${[hitX, hitY]} is not ${[x, y]}`);
  }));

  await allHave(windows, expected);
});

test('where no WebSocket passes five windows edit and pick; a sixth says what to do, and goes on when one is closed', async (t) => {
  const context = await openContext(t);
  await stopWebSockets(context);
  const windows = await openWindows(context, 5);
  const expected = await controlPoints();

  const sixth = await openWindow(context);
  await sixth.locator('.banner').getByText('without WebSockets a browser shows 5 of its windows at once: close one of them').waitFor();
  await Promise.all(windows.map(async (window, i) => {
    await move(window, 7 * i, 1, expected);
    assert.ok(await pickBelow(window, 1, 0));
  }));
  await allHave(windows, expected);

  await windows[0].close();
  await live(sixth);
  await sixth.locator('.banner').waitFor({ state: 'hidden' });
  await move(sixth, 63, 1, expected);
  await allHave([...windows.slice(1), sixth], expected);
});

/** The toasts of a page since keepToasts(). */
function toasts(of: Page): Promise<string[]> {
  return of.evaluate(() => (window as unknown as { toasts: string[] }).toasts);
}

test('two windows go on after their server was killed: edits made meanwhile are there once, and can be undone', async (t) => {
  const [first, second] = [...(await openWindows(await openContext(t), 1)), ...(await openWindows(await openContext(t), 1))];
  const windows = [first, second];
  for (const window of windows) await keepToasts(window);
  const expected = await controlPoints();

  await server.kill();
  for (const window of windows) await window.locator('.connection[data-state=retrying]').waitFor();
  await move(first, 21, 1, expected); // while the server is down
  await move(second, 63, 2, expected);
  await server.restart();

  await allHave(windows, expected);
  await move(first, 5, 3, expected);
  await move(second, 42, 1, expected);
  await allHave(windows, expected);
  for (let steps = 0; steps < 2; ++steps) await second.evaluate(() => window.latticed.scene!.session.undo());
  expected[3 * 42 + 2] += 0.25;
  expected[3 * 63 + 2] += 0.5;
  await allHave(windows, expected);
  for (const window of windows) assert.deepEqual(await toasts(window), []);
});

test('a move by G whose server is killed goes on in the cage, and is one step when the server is back', async () => {
  await openTorus();
  scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  await page.evaluate(() => window.latticed.settings.set({ gizmo: 'none' }));
  await keepToasts(page);
  await frames(page);
  const rest = await allPoints();
  const [x, y] = await onScreen(page, CORNER);
  await select(CORNER);
  await page.mouse.move(x, y);
  await press('g');
  await page.mouse.move(x - 20, y + 10, { steps: 4 });
  await until(async () => (await controlPoints())[3 * CORNER] !== rest[3 * CORNER]);
  await page.mouse.move(x - 40, y + 20, { steps: 4 }); // some of these moves are not answered yet
  await server.kill();
  await page.locator('.connection[data-state=retrying]').waitFor();
  const cut = await controlPoint(page, CORNER);
  await page.mouse.move(x - 60, y + 30, { steps: 4 });
  assert.notDeepEqual(await controlPoint(page, CORNER), cut); // the cage moves without a server

  await server.restart();
  await page.locator('.connection[data-state=live]').waitFor();
  await page.mouse.move(x - 100, y + 80, { steps: 4 });
  await press('Enter');
  const there = await controlPoint(page, CORNER);
  await allHave([page], rest.map((value, i) => (i >= 3 * CORNER ? there[i - 3 * CORNER] : value)));
  await press('Control+z');
  await allHave([page], rest);
  assert.deepEqual(await toasts(page), []);
});

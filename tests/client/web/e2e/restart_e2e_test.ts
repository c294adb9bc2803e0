// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Two windows on one scene when the server, which keeps nothing, is killed and started again: one of them is quicker and
// restores the scene, the other goes on with it. Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import type { Browser, BrowserContext, Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { LatticedServer } from '@src/wire/latticed_server';
import { launch } from './browser';
import { followsDefinition } from './definition';
import { ServerProcess } from './server_process';
import { torusObj } from './torus';
import { createScene, dropFiles, live, promised } from './viewer_page';

const OBJ = torusObj(12, 8);
const RESTORED = 'The server was restarted; (this browser|another window) restored mesh and lattice';

let server: ServerProcess;
let direct: LatticedServer;
let browser: Browser;

async function openWindow(context: BrowserContext, path: string): Promise<Page> {
  const page = await context.newPage();
  await page.goto(server.origin + path);
  return page;
}

/** Moves a control point down by quarters, whose sums are exact. */
function move(page: Page, index: number, quarters: number): Promise<void> {
  return page.evaluate(
    ([i, n]) => window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(i), offset: [0, 0, -n / 4] }),
    [index, quarters] as const,
  );
}

/** `points` with one moved down. */
function moved(points: readonly number[], index: number, quarters: number): number[] {
  return points.map((value, i) => (i === 3 * index + 2 ? value - quarters / 4 : value));
}

function shownBy(page: Page): Promise<number[]> {
  return page.evaluate(() => [...window.latticed.scene!.session.lattice.points]);
}

/** Waits until the server and all windows have these control points, and surfaces are where those put them. */
async function allHave(scene: string, windows: readonly Page[], expected: readonly number[]): Promise<void> {
  for (const page of windows) {
    await page.waitForFunction((all) => String(window.latticed.scene!.session.lattice.points) === all, String(expected), { timeout: 60_000 });
  }
  for (const end = Date.now() + 60_000; ; await windows[0].waitForTimeout(20)) {
    const { lattice } = await direct.scenes.getLattice({ scene });
    if (String(lattice!.controlPoints) === String(expected)) break;
    assert.ok(Date.now() < end, `the server has ${lattice!.controlPoints}, not ${expected}`);
  }
  for (const page of windows) await followsDefinition(page, OBJ);
}

/** Waits until the browser has what it takes to restore the scene: only then may the server go. */
async function keeps(page: Page): Promise<void> {
  await promised(page, async () => {
    const done = <T>(request: IDBRequest<T>): Promise<T> => new Promise((resolve, reject) => {
      request.onsuccess = () => resolve(request.result);
      request.onerror = () => reject(request.error);
    });
    const database = await done(indexedDB.open('latticed'));
    const tables = database.transaction(['scenes', 'contents']);
    const [scene, meshes] = await Promise.all([
      done(tables.objectStore('scenes').get(window.latticed.scene!.session.sceneId)), done(tables.objectStore('contents').count())]);
    database.close();
    return scene !== undefined && meshes > 0;
  });
}

/** Keeps what the page tells from now on: its toasts go after some seconds. */
function keepToasts(page: Page): Promise<void> {
  return page.evaluate(() => {
    const toasts: string[] = [];
    Object.assign(window, { toasts });
    new MutationObserver((changes) => {
      for (const { addedNodes } of changes) {
        for (const node of addedNodes) if (node instanceof HTMLElement && node.matches('.toast')) toasts.push(node.innerText);
      }
    }).observe(document.body, { childList: true, subtree: true });
  });
}

/** Waits until the page says so. */
async function whoRestored(page: Page): Promise<string> {
  const said = await page.waitForFunction((words) => {
    const { toasts } = window as unknown as { toasts: string[] };
    return toasts.map((text) => new RegExp(words).exec(text)?.[1]).find(Boolean);
  }, RESTORED, { timeout: 60_000 });
  return (await said.jsonValue())!;
}

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_VIEWER!);
  direct = new LatticedServer(server.origin);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await server?.kill();
});

for (const [whose, isOther] of [['one browser', false], ['two browsers', true]] as const) {
  test(`two windows of ${whose}: a scene is restored once, both say so, and edits of either one are right in the other`, async (t) => {
    const view = { viewport: { width: 480, height: 360 } };
    const context = await browser.newContext(view);
    const otherContext = isOther ? await browser.newContext(view) : context;
    t.after(async () => {
      await context.close();
      if (isOther) await otherContext.close();
    });
    const first = await openWindow(context, '/');
    await dropFiles(first, [['torus.obj', OBJ]]);
    await createScene(first);
    const { pathname, search } = new URL(first.url());
    const second = await openWindow(otherContext, pathname + search);
    const windows = [first, second];
    const scene = await first.evaluate(() => window.latticed.scene!.session.sceneId);
    for (const page of windows) {
      await live(page);
      await page.evaluate(() => window.latticed.scene!.session.setView({ segments: 2 })); // few points: one processor draws all
      await keeps(page);
      await keepToasts(page);
    }
    await move(first, 0, 1);
    let expected = await shownBy(first);
    await allHave(scene, windows, expected);

    await server.kill();
    for (const page of windows) await page.locator('.connection[data-state=retrying]').waitFor();
    await move(first, 21, 1); // people go on meanwhile
    await move(second, 63, 2);
    await server.restart();

    const said = await Promise.all(windows.map(whoRestored));
    assert.deepEqual(said.sort(), ['another window', 'this browser']);
    expected = moved(moved(expected, 21, 1), 63, 2);
    await allHave(scene, windows, expected);
    assert.deepEqual((await direct.scenes.listScenes({})).scenes.map(({ id }) => id), [scene]);
    await move(first, 5, 3);
    await move(second, 42, 1);
    expected = moved(moved(expected, 5, 3), 42, 1);
    await allHave(scene, windows, expected);
    await second.evaluate(() => window.latticed.scene!.session.undo());
    expected = moved(expected, 42, -1);
    await allHave(scene, windows, expected);
  });
}

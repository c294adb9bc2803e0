// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pages whose server, which keeps nothing, is killed and started again.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { LatticedServer } from '@src/wire/latticed_server';
import { launch } from './browser';
import { followsDefinition } from './definition';
import { ServerProcess } from './server_process';
import { promised } from './viewer_page';

const RESTORED = 'The server was restarted; (this browser|another window) restored mesh and lattice';

export interface Stage {
  server: ServerProcess;
  /** Calls of the server that no page makes. */
  direct: LatticedServer;
  browser: Browser;
}

/** What all tests of a file have from before the first until after the last. */
export function stageOfFile(): Stage {
  const stage = {} as Stage;
  before(async () => {
    stage.server = await ServerProcess.start(process.env.LATTICED_VIEWER!);
    stage.direct = new LatticedServer(stage.server.origin);
    stage.browser = await launch();
  });
  after(async () => {
    await stage.browser?.close();
    await stage.server?.kill();
  });
  return stage;
}

/** The control points that a page shows. */
export function shownBy(page: Page): Promise<number[]> {
  return page.evaluate(() => [...window.latticed.scene!.session.lattice.points]);
}

/** Waits until the server and all windows have these control points, and surfaces are where those put them. */
export async function allHave(
  direct: LatticedServer, scene: string, windows: readonly Page[], expected: readonly number[], obj: string,
): Promise<void> {
  for (const page of windows) {
    await page.waitForFunction((all) => String(window.latticed.scene!.session.lattice.points) === all, String(expected), { timeout: 60_000 });
  }
  for (const end = Date.now() + 60_000; ; await windows[0].waitForTimeout(20)) {
    const { lattice } = await direct.scenes.getLattice({ scene });
    if (String(lattice!.controlPoints) === String(expected)) break;
    assert.ok(Date.now() < end, `the server has ${lattice!.controlPoints}, not ${expected}`);
  }
  for (const page of windows) await followsDefinition(page, obj);
}

/** Waits until the browser has what it takes to restore the scene: only then may the server go. */
export async function keeps(page: Page): Promise<void> {
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
export function keepToasts(page: Page): Promise<void> {
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

/** Waits until the page has told what fits, and returns the first group of that. */
export async function toldOf(page: Page, words: string): Promise<string> {
  const said = await page.waitForFunction((pattern) => {
    const { toasts } = window as unknown as { toasts: string[] };
    const found = toasts.map((text) => new RegExp(pattern).exec(text)).find(Boolean);
    return found && { group: found[1] ?? '' };
  }, words, { timeout: 60_000 });
  return (await said.jsonValue())!.group;
}

/** Waits until the page says so. */
export function whoRestored(page: Page): Promise<string> {
  return toldOf(page, RESTORED);
}

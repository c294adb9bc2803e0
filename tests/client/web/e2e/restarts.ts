// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pages whose server, which keeps nothing, is killed and started again.
import type { Page } from 'playwright-core';
import { followsDefinition } from './definition';
import { direct, until } from './stage';
import { promised } from './viewer_page';

const RESTORED = 'The server was restarted; (this browser|another window) restored mesh and lattice';

/** Waits until the server and all windows have these control points, and surfaces are where those put them. */
export async function allHave(
  scene: string, windows: readonly Page[], expected: readonly number[], obj: string,
): Promise<void> {
  for (const page of windows) {
    await page.waitForFunction((all) => String(window.latticed.scene!.session.lattice.points) === all, String(expected), { timeout: 60_000 });
  }
  await until(async () => String((await direct.scenes.getLattice({ scene })).lattice!.controlPoints) === String(expected));
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

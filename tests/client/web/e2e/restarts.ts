// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// For tests that kill and restart a page's server, which keeps nothing.
import type { Page } from 'playwright-core';
import { until } from '../support/until';

const RESTORED = 'The server was restarted; (this browser|another window) restored mesh and lattice';

/** Waits until the browser stores what it needs to restore the page's scene. Only then may a test kill the server. */
export async function keeps(page: Page): Promise<void> {
  await until(() => page.evaluate(() => new Promise<boolean>((resolve) => {
    const { opener, scene } = window.latticed;
    const request = indexedDB.open('latticed');
    request.onsuccess = () => {
      const transaction = request.result.transaction(['meshes', 'scenes']);
      const mesh = transaction.objectStore('meshes').getKey((opener as unknown as { mesh: { id: string } }).mesh.id);
      const kept = transaction.objectStore('scenes').getKey(scene!.session.sceneId);
      request.result.close(); // takes effect after the transaction
      transaction.oncomplete = () => resolve(mesh.result !== undefined && kept.result !== undefined);
    };
  })));
}

/** Records the page's toasts from now on. A toast disappears after some seconds. */
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

/** Waits until a recorded toast matches `words`. Returns the first group of the match. */
export async function toldOf(page: Page, words: string): Promise<string> {
  const said = await page.waitForFunction((pattern) => {
    const { toasts } = window as unknown as { toasts: string[] };
    const found = toasts.map((text) => new RegExp(pattern).exec(text)).find(Boolean);
    return found && { group: found[1] ?? '' };
  }, words);
  return (await said.jsonValue())!.group;
}

/** Waits until a toast says who restored the scene: "this browser" or "another window". */
export function whoRestored(page: Page): Promise<string> {
  return toldOf(page, RESTORED);
}

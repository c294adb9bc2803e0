// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// For tests that kill and restart a page's server.
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after } from 'node:test';
import type { Page } from 'playwright-core';

/** Options of a server that keeps its data in a folder, which is deleted after the tests. */
export function withData(): readonly string[] {
  const folder = mkdtempSync(join(tmpdir(), 'latticed-'));
  after(() => rmSync(folder, { recursive: true }));
  return ['--data-dir', folder];
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

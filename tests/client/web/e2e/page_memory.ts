// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a page takes in Chromium: JavaScript's objects and buffers by themselves, and all of its processes, in which workers,
// WebAssembly and what is drawn lie as well.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import type { CDPSession, Page } from 'playwright-core';

const OS_PAGE_BYTES = 4096;

/** How much more a page may take. */
const LIMITS = { objects: 2e6, buffers: 1e5, nodes: 50, listeners: 10, processes: 32e6 };

/**
 * Runs something that has run before, and fails where the page takes more afterwards. Collections of garbage and caches
 * leave less than the limits; a buffer of a kilobyte at each of a thousand steps is more.
 */
export async function assertFlat(page: Page, run: () => Promise<unknown>): Promise<void> {
  const session = await page.context().newCDPSession(page);
  const processes = await processesOf(page);
  const before = await taken(session);
  await run();
  const after = await taken(session);
  await session.detach();
  const grown = {
    objects: after.objects - before.objects, buffers: after.buffers - before.buffers,
    nodes: after.nodes - before.nodes, listeners: after.listeners - before.listeners,
    processes: processes.reduce((sum, { id, bytes }) => sum + (privateBytes(id) || bytes) - bytes, 0),
  };
  const kinds = Object.keys(LIMITS) as (keyof typeof LIMITS)[];
  assert.ok(kinds.every((kind) => grown[kind] <= LIMITS[kind]), `more than before: ${JSON.stringify(grown)}`);
}

/** Bytes after a collection of garbage, and numbers of what the document has. */
async function taken(session: CDPSession): Promise<Record<'objects' | 'buffers' | 'nodes' | 'listeners', number>> {
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize, embedderHeapUsedSize, backingStorageSize: buffers } = await session.send('Runtime.getHeapUsage');
  const { nodes, jsEventListeners: listeners } = await session.send('Memory.getDOMCounters');
  return { objects: usedSize + embedderHeapUsedSize, buffers, nodes, listeners };
}

/** Those that run pages, and the GPU's. */
async function processesOf(page: Page): Promise<{ id: number; bytes: number }[]> {
  const session = await page.context().browser()!.newBrowserCDPSession();
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  await session.detach();
  return processInfo.filter(({ type }) => type === 'renderer' || type === 'GPU').map(({ id }) => ({ id, bytes: privateBytes(id) }));
}

/** Resident pages but for those that files and other processes share (proc(5), statm); 0 of a process that has ended. */
function privateBytes(process: number): number {
  const file = `/proc/${process}/statm`;
  if (!existsSync(file)) return 0;
  const [, resident, shared] = readFileSync(file, 'latin1').split(' ').map(Number);
  return OS_PAGE_BYTES * (resident - shared);
}

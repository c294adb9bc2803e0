// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory that a page takes in Chromium: JavaScript's objects and buffers, and all of its processes, which also hold
// workers, WebAssembly and what is drawn.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import type { CDPSession, Page } from 'playwright-core';

const OS_PAGE_BYTES = 4096;

/** By how much each number may grow. */
const LIMITS = { objects: 2e6, buffers: 1e5, nodes: 50, listeners: 10, processes: 32e6 };

/**
 * Runs something that has run before, and fails if the page takes more memory afterwards, twice in a row. Garbage and caches
 * leave less than the limits, but what a slow machine has not finished may not. A leak of a kilobyte of buffers at each of a
 * thousand steps exceeds them each time.
 */
export async function assertFlat(page: Page, run: () => Promise<unknown>): Promise<void> {
  const first = await grows(page, run);
  if (first === undefined) return;
  const second = await grows(page, run);
  assert.equal(second, undefined, `more than before: ${first}, then ${second}`);
}

/** Runs something, and returns by how much the page then takes more, if that is above a limit. */
async function grows(page: Page, run: () => Promise<unknown>): Promise<string | undefined> {
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
  return kinds.every((kind) => grown[kind] <= LIMITS[kind]) ? undefined : JSON.stringify(grown);
}

/** Bytes after a garbage collection, and the document's numbers of nodes and listeners. */
async function taken(session: CDPSession): Promise<Record<'objects' | 'buffers' | 'nodes' | 'listeners', number>> {
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize, embedderHeapUsedSize, backingStorageSize: buffers } = await session.send('Runtime.getHeapUsage');
  const { nodes, jsEventListeners: listeners } = await session.send('Memory.getDOMCounters');
  return { objects: usedSize + embedderHeapUsedSize, buffers, nodes, listeners };
}

/** The processes that run pages, and the GPU process. */
async function processesOf(page: Page): Promise<{ id: number; bytes: number }[]> {
  const session = await page.context().browser()!.newBrowserCDPSession();
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  await session.detach();
  return processInfo.filter(({ type }) => type === 'renderer' || type === 'GPU').map(({ id }) => ({ id, bytes: privateBytes(id) }));
}

/** Bytes of resident pages that are not shared with files or processes (proc(5), statm). 0 if the process has ended. */
function privateBytes(process: number): number {
  const file = `/proc/${process}/statm`;
  if (!existsSync(file)) return 0;
  const [, resident, shared] = readFileSync(file, 'latin1').split(' ').map(Number);
  return OS_PAGE_BYTES * (resident - shared);
}

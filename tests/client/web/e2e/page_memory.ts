// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a page takes in Chromium. JavaScript's objects are the least of it: buffers and WebAssembly lie beside them,
// workers have their own, and what is drawn is in the GPU's process.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import type { CDPSession, Page } from 'playwright-core';

/** Bytes after a collection of garbage. */
interface ScriptMemory {
  /** JavaScript's, and the browser's own that scripts hold. */
  readonly objects: number;
  /** Contents of ArrayBuffers. */
  readonly buffers: number;
  /** WebAssembly's memories. */
  readonly wasm: number;
}

/** Of the page and its workers together. */
interface PageMemory extends ScriptMemory {
  /** Numbers of what the document has. */
  readonly nodes: number;
  readonly listeners: number;
  /** Resident and private bytes by process, of those that run pages and the GPU's. */
  readonly processes: ReadonlyMap<number, number>;
}

/** Calls a method of the DevTools protocol. */
type Call = <Result>(method: string, params?: object) => Promise<Result>;

/** A worker's answer to a call. */
interface Answer {
  readonly result: never;
  readonly error?: { readonly message: string };
}

const OS_PAGE_BYTES = 4096;

/** How much more a page may take. */
const LIMITS: Record<keyof PageMemory, number> = { objects: 2e6, buffers: 1e5, wasm: 4e6, nodes: 50, listeners: 10, processes: 32e6 };

class MemoryProbe {
  private readonly workers = new Map<string, Call>();  // by session
  private readonly waiting = new Map<number, (answer: Answer) => void>();
  private lastId = 0;

  private constructor(private readonly session: CDPSession, private readonly browser: CDPSession) {}

  static async of(page: Page): Promise<MemoryProbe> {
    const probe = new MemoryProbe(
      await page.context().newCDPSession(page), await page.context().browser()!.newBrowserCDPSession());
    await probe.attachToWorkers();
    return probe;
  }

  async taken(): Promise<PageMemory> {
    const page = this.session.send.bind(this.session) as Call;
    const parts: ScriptMemory[] = [];
    for (const call of [page, ...this.workers.values()]) parts.push(await takenBy(call));
    const sum = (of: keyof ScriptMemory): number => parts.reduce((total, part) => total + part[of], 0);
    const { nodes, jsEventListeners } = await this.session.send('Memory.getDOMCounters');
    return { objects: sum('objects'), buffers: sum('buffers'), wasm: sum('wasm'), nodes, listeners: jsEventListeners,
      processes: await this.processes() };
  }

  async close(): Promise<void> {
    await this.session.detach();
    await this.browser.detach();
  }

  /** Playwright has no sessions of workers: their messages are wrapped in the page's. */
  private async attachToWorkers(): Promise<void> {
    this.session.on('Target.attachedToTarget', ({ sessionId, targetInfo }) => {
      if (targetInfo.type === 'worker') this.workers.set(sessionId, (method, params) => this.callWorker(sessionId, method, params));
    });
    this.session.on('Target.detachedFromTarget', ({ sessionId }) => this.workers.delete(sessionId));
    this.session.on('Target.receivedMessageFromTarget', ({ message }) => {
      const answer = JSON.parse(message);
      this.waiting.get(answer.id)?.(answer);
      this.waiting.delete(answer.id);
    });
    await this.session.send('Target.setAutoAttach', { autoAttach: true, waitForDebuggerOnStart: false, flatten: false });
  }

  private callWorker<Result>(sessionId: string, method: string, params: object = {}): Promise<Result> {
    const id = ++this.lastId;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, ({ result, error }) => (error ? reject(new Error(`${method}: ${error.message}`)) : resolve(result)));
      this.session.send('Target.sendMessageToTarget', { sessionId, message: JSON.stringify({ id, method, params }) }).catch(reject);
    });
  }

  private async processes(): Promise<Map<number, number>> {
    const { processInfo } = await this.browser.send('SystemInfo.getProcessInfo');
    const found = processInfo.filter(({ type }) => type === 'renderer' || type === 'GPU');
    return new Map(found.map(({ id }) => [id, privateBytes(id)]));
  }
}

/**
 * Runs something that has run before, and fails where the page takes more afterwards. Collections of garbage and caches
 * leave less than the limits; a buffer of a kilobyte at each of a thousand steps is more.
 */
export async function assertFlat(page: Page, run: () => Promise<unknown>): Promise<void> {
  const probe = await MemoryProbe.of(page);
  const before = await probe.taken();
  await run();
  const grown = growth(before, await probe.taken());
  await probe.close();
  assert.ok(before.wasm > 0, 'no worker was found');
  const kinds = Object.keys(LIMITS) as (keyof PageMemory)[];
  assert.ok(kinds.every((kind) => grown[kind] <= LIMITS[kind]), `more than before: ${JSON.stringify(grown)}`);
}

function growth(before: PageMemory, after: PageMemory): Record<keyof PageMemory, number> {
  // Browsers keep a process in reserve, and end others: those that are there at both times count.
  const grown = [...before.processes].map(([id, bytes]) => (after.processes.get(id) || bytes) - bytes);
  return {
    objects: after.objects - before.objects, buffers: after.buffers - before.buffers, wasm: after.wasm - before.wasm,
    nodes: after.nodes - before.nodes, listeners: after.listeners - before.listeners,
    processes: grown.reduce((sum, bytes) => sum + bytes, 0),
  };
}

async function takenBy(call: Call): Promise<ScriptMemory> {
  await call('HeapProfiler.collectGarbage');
  const heap = await call<{ usedSize: number; embedderHeapUsedSize: number; backingStorageSize: number }>('Runtime.getHeapUsage');
  return { objects: heap.usedSize + heap.embedderHeapUsedSize, buffers: heap.backingStorageSize, wasm: await wasmBytes(call) };
}

async function wasmBytes(call: Call): Promise<number> {
  const objectGroup = 'wasm';
  const { result } = await call<{ result: { objectId: string } }>(
    'Runtime.evaluate', { expression: 'WebAssembly.Memory.prototype', objectGroup });
  const { objects } = await call<{ objects: { objectId: string } }>(
    'Runtime.queryObjects', { prototypeObjectId: result.objectId, objectGroup });
  const sum = 'function () { return this.reduce((bytes, { buffer }) => bytes + buffer.byteLength, 0); }';
  const answer = await call<{ result: { value: number } }>(
    'Runtime.callFunctionOn', { objectId: objects.objectId, functionDeclaration: sum, returnByValue: true });
  await call('Runtime.releaseObjectGroup', { objectGroup });
  return answer.result.value;
}

/** Resident pages but for those that files and other processes share (proc(5), statm); 0 of a process that has ended. */
function privateBytes(process: number): number {
  const file = `/proc/${process}/statm`;
  if (!existsSync(file)) return 0;
  const [, resident, shared] = readFileSync(file, 'latin1').split(' ').map(Number);
  return OS_PAGE_BYTES * (resident - shared);
}

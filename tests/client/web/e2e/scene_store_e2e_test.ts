// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What Chromium keeps for the page: of other versions of it, of several windows, and where there is little room.
// Environment: LATTICED, CHROMIUM; LATTICED_PAGE, the folder of the page.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import type { Browser, BrowserContext, Page } from 'playwright-core';
import { launch, launchWithProfile, limitStorage } from './browser';
import { ServerProcess } from './server_process';
import type {} from './page/harness';  // window.harness

let server: ServerProcess;
let browser: Browser;
let context: BrowserContext;

async function openHarness(): Promise<Page> {
  const page = await context.newPage();
  await page.goto(server.origin);
  return page;
}

/** A page of the same origin that asks for no database by itself. */
async function openBare(): Promise<Page> {
  const page = await context.newPage();
  await page.goto(`${server.origin}/harness.js`);
  return page;
}

/** Makes the database that version 2 of the page did, with scene 1 of mesh a; `release` closes the connection. */
function makeVersion2(page: Page): Promise<void> {
  return page.evaluate(() => new Promise<void>((resolve) => {
    const request = indexedDB.open('latticed', 2);
    request.onupgradeneeded = () => {
      const { result, transaction } = request;
      for (const name of ['scenes', 'meshes']) result.createObjectStore(name, { keyPath: 'id' });
      result.createObjectStore('contents');
      transaction!.objectStore('scenes').put({ id: '1', mesh: 'a', bootId: '', request: new Uint8Array([7]), savedAt: 1 });
      transaction!.objectStore('meshes').put({ id: 'a', header: new Uint8Array(), bytes: 3, savedAt: Date.now() });
      transaction!.objectStore('contents').put(new Blob(['mmm']), 'a');
    };
    request.onsuccess = () => {
      Object.assign(window, { release: () => request.result.close() });
      resolve();
    };
  }));
}

function save(page: Page, mesh: string, files: readonly (readonly [name: string, content: string])[], beside: boolean): Promise<void> {
  return page.evaluate(([id, list, isBeside]) => {
    const made = list.map(([name, content]) => new File([content], name));
    return window.harness.store.saveCompanions(id, made, isBeside);
  }, [mesh, files, beside] as const);
}

/** Names and contents. */
function beside(page: Page, mesh: string): Promise<string[]> {
  return page.evaluate(async (id) => {
    const files = await window.harness.store.companions(id);
    return Promise.all(files.map(async (file) => `${file.name} ${await file.text()}`));
  }, mesh);
}

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_PAGE!);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await server?.kill();
});

test('what a window of version 2 keeps is there in version 3, which waits until that window lets go of it', async () => {
  context = await browser.newContext();
  const old = await openBare();
  await makeVersion2(old);
  await context.addInitScript(() => {
    const open = indexedDB.open.bind(indexedDB);
    indexedDB.open = (name, version) => {
      const request = open(name, version);
      request.addEventListener('blocked', () => Object.assign(window, { isBlocked: true }));
      return request;
    };
  });
  const page = await openHarness();
  await page.evaluate(() => Object.assign(window, { scene: window.harness.store.scene('1') }));
  await page.waitForFunction(() => (window as unknown as { isBlocked?: boolean }).isBlocked);

  await old.evaluate(() => (window as unknown as { release(): void }).release());
  const kept = await page.evaluate(async () => {
    const scene = await (window as unknown as { scene: Promise<{ request: Uint8Array } | undefined> }).scene;
    const mesh = await window.harness.store.mesh('a');
    return [scene?.request[0], await mesh?.content.text()];
  });
  assert.deepEqual(kept, [7, 'mmm']);
  await save(page, 'a', [['a.png', 'four']], true);
  const facts = await page.evaluate(() => new Promise((resolve) => {
    const request = indexedDB.open('latticed');
    request.onsuccess = () => {
      const found = request.result.transaction('meshes').objectStore('meshes').get('a');
      found.onsuccess = () => resolve([found.result.bytes, found.result.companionBytes]);
      request.result.close();
    };
  }));
  assert.deepEqual(facts, [7, 4]);
  await context.close();
});

test('a page whose database was deleted makes another; one that is older than it asks to be reloaded', async () => {
  context = await browser.newContext();
  const page = await openHarness();
  await save(page, 'a', [['a.png', 'A']], true);
  const other = await openBare();
  await other.evaluate(() => new Promise<void>((resolve) => (indexedDB.deleteDatabase('latticed').onsuccess = () => resolve())));
  assert.deepEqual(await beside(page, 'a'), []);
  await save(page, 'a', [['b.png', 'B']], true);
  assert.deepEqual(await beside(page, 'a'), ['b.png B']);

  await other.evaluate(() => new Promise<void>((resolve) => (indexedDB.open('latticed', 1000).onsuccess = () => resolve())));
  const refusals = await page.evaluate(async () => {
    const { store } = window.harness;
    const calls = [store.scene('1'), store.mesh('a'), store.saveCompanions('a', [])];
    return (await Promise.allSettled(calls)).map((result) => (result.status === 'rejected' ? (result.reason as Error).message : 'done'));
  });
  assert.deepEqual(refusals, Array(3).fill('another window has a newer version of this page: reload this one'));
  await context.close();
});

test('pictures that two windows keep beside one mesh are there all, the newest of each name; those in place of all are alone', async () => {
  context = await browser.newContext();
  const [first, second] = [await openHarness(), await openHarness()];

  await save(first, 'a', [['a.png', '1'], ['b.png', '1']], false);
  await Promise.all([save(first, 'a', [['c.png', '2']], true), save(second, 'a', [['b.png', '2']], true)]);
  assert.deepEqual((await beside(second, 'a')).sort(), ['a.png 1', 'b.png 2', 'c.png 2']);
  await save(second, 'a', [['a.png', '3']], true);
  assert.equal((await beside(first, 'a')).at(-1), 'a.png 3');
  await save(second, 'a', [['d.png', '3']], false);
  assert.deepEqual(await beside(first, 'a'), ['d.png 3']);
  await context.close();
});

test('what is kept beside a mesh before the mesh is counts as room that can be freed', async (t) => {
  context = await launchWithProfile(t);
  const page = await openHarness();
  await limitStorage(page, 10e6);
  const saveMesh = (mesh: string, megabytes: number): Promise<void> => page.evaluate(([id, size]) =>
    window.harness.store.saveMesh({ id, header: new Uint8Array(), content: new Blob([new Uint8Array(size * 1e6)]) }), [mesh, megabytes] as const);
  await page.evaluate(() => window.harness.store.saveCompanions('a', [new File([new Uint8Array(5e6)], 'a.png')]));
  await saveMesh('a', 1);

  await saveMesh('b', 5);
  assert.equal(await page.evaluate(() => window.harness.store.keepsMesh('b')), true);
  assert.deepEqual(await beside(page, 'a'), []);
});

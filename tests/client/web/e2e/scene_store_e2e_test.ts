// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The page's storage in Chromium: with other versions of the page, with several windows, and with little room.
// Environment: LATTICED, CHROMIUM; LATTICED_PAGE, the folder of the page.
import assert from 'node:assert/strict';
import { after, before, test, type TestContext } from 'node:test';
import type { Browser, BrowserContext, Page } from 'playwright-core';
import { launch, launchWithProfile, limitStorage } from './browser';
import { ServerProcess } from './server_process';
import type {} from './page/harness'; // window.store

let server: ServerProcess;
let browser: Browser;
let context: BrowserContext;

async function openHarness(): Promise<Page> {
  const page = await context.newPage();
  await page.goto(server.origin);
  return page;
}

/** A page of the same origin that does not open the database itself. */
async function openBare(): Promise<Page> {
  const page = await context.newPage();
  await page.goto(`${server.origin}/no-such-page`);
  return page;
}

function save(page: Page, mesh: string, files: readonly (readonly [name: string, content: string])[], beside: boolean): Promise<void> {
  return page.evaluate(([id, list, isBeside]) => {
    const made = list.map(([name, content]) => new File([content], name));
    return window.store.saveCompanions(id, made, isBeside);
  }, [mesh, files, beside] as const);
}

/** The names and contents of the files stored beside a mesh. */
function beside(page: Page, mesh: string): Promise<string[]> {
  return page.evaluate(async (id) => {
    const files = await window.store.companions(id);
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

test('what an older page keeps is dropped by a newer one, which waits until the older one lets go of it', async () => {
  context = await browser.newContext();
  const old = await openBare();
  await old.evaluate(() => new Promise<void>((resolve) => {
    const request = indexedDB.open('latticed', 2);
    request.onupgradeneeded = () => request.result.createObjectStore('scenes').put({ id: '1' }, '1');
    request.onsuccess = () => {
      Object.assign(window, { release: () => request.result.close() });
      resolve();
    };
  }));
  await context.addInitScript(() => {
    const open = indexedDB.open.bind(indexedDB);
    indexedDB.open = (name, version) => {
      const request = open(name, version);
      request.addEventListener('blocked', () => Object.assign(window, { isBlocked: true }));
      return request;
    };
  });
  const page = await openHarness();
  await page.evaluate(() => Object.assign(window, { saved: window.store.saveCompanions('a', [new File(['A'], 'a.png')]) }));
  await page.waitForFunction(() => (window as unknown as { isBlocked?: boolean }).isBlocked);

  await old.evaluate(() => (window as unknown as { release(): void }).release());
  await page.evaluate(() => (window as unknown as { saved: Promise<void> }).saved);
  assert.deepEqual(await beside(page, 'a'), ['a.png A']);
  assert.equal(await page.evaluate(() => window.store.scene('1')), undefined);
  await context.close();
});

test('a page whose database was deleted makes another; one that is older than it keeps nothing, and says so', async () => {
  context = await browser.newContext();
  const page = await openHarness();
  await save(page, 'a', [['a.png', 'A']], true);
  const other = await openBare();
  await other.evaluate(() => new Promise<void>((resolve) => (indexedDB.deleteDatabase('latticed').onsuccess = () => resolve())));
  assert.deepEqual(await beside(page, 'a'), []);
  await save(page, 'a', [['b.png', 'B']], true);
  assert.deepEqual(await beside(page, 'a'), ['b.png B']);

  await other.evaluate(() => new Promise<void>((resolve) => (indexedDB.open('latticed', 1000).onsuccess = () => resolve())));
  const refusal = await page.evaluate(() => window.store.saveCompanions('a', []).catch((error: Error) => error.message));
  assert.match(String(refusal), /^the browser keeps nothing for this page, as in some private windows \(.*version/);
  assert.deepEqual(await beside(page, 'a'), []);
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

/** A page in its own browser, whose storage is 10 MB. */
async function storingPage(t: TestContext): Promise<Page> {
  const storing = await (await launchWithProfile(t)).newPage();
  await storing.goto(server.origin);
  await limitStorage(storing, 10e6);
  return storing;
}

test('for a mesh without room the oldest scenes are forgotten, none in vain; what is refused stays with the page', async (t) => {
  const storing = await storingPage(t);
  /** Which of the meshes a to d and the scenes 1 to 3 exist. A mesh in capitals is only in the page. */
  const there = (): Promise<string> => storing.evaluate(async () => {
    const { store } = window;
    const found = [...'abcd'].map(async (id) =>
      (await store.keepsMesh(id)) ? id : (await store.mesh(id)) ? id.toUpperCase() : '');
    const scenes = [...'123'].map(async (id) => ((await store.scene(id)) ? id : ''));
    return (await Promise.all([...found, ...scenes])).join('');
  });
  const save = (meshes: [id: string, megabytes: number][], scenes: [id: string, mesh: string][]): Promise<string> =>
    storing.evaluate(async ([files, users]) => {
      const { store } = window;
      try {
        for (const [id, megabytes] of files) {
          await store.saveMesh({ id, header: new Uint8Array(), content: new Blob([new Uint8Array(megabytes * 1e6)]) });
        }
        for (const [id, mesh] of users) {
          await store.saveScene({ id, mesh, bootId: '', request: new Uint8Array(), savedAt: Number(id) });
        }
        return '';
      } catch (error) {
        return (error as Error).message;
      }
    }, [meshes, scenes] as const);

  assert.equal(await save([['a', 4], ['b', 4], ['b', 4]], [['1', 'a'], ['2', 'b'], ['3', 'b']]), '');
  assert.equal(await there(), 'ab123');
  assert.equal(await save([['c', 3]], []), '');
  assert.equal(await there(), 'bc23');
  assert.equal(await save([['d', 8]], []), 'the browser has no room left for it'); // b and c together take 7 MB
  assert.equal(await there(), 'bcD23');
  await storing.reload();
  assert.equal(await there(), 'bc23');
  await storing.evaluate(() => {
    const { now } = Date;
    Date.now = () => now() + 2 * 3600 * 1000; // no scene uses c
    return window.store.forgetOld();
  });
  assert.equal(await there(), 'b23');
});

test('what was dropped beside a mesh is kept with it, counts with it for room, and is forgotten with it', async (t) => {
  const storing = await storingPage(t);
  const keep = (mesh: string, megabytes: number): Promise<string> => storing.evaluate(async ([id, size]) => {
    const files = [new File([new Uint8Array(size * 1e6)], `${size} of ${id}.png`)];
    return window.store.saveCompanions(id, files).then(() => '', (error: Error) => error.message);
  }, [mesh, megabytes] as const);
  const makeScene = (id: string, mesh: string, megabytes: number): Promise<void> => storing.evaluate(async ([scene, file, size]) => {
    const { store } = window;
    await store.saveMesh({ id: file, header: new Uint8Array(), content: new Blob([new Uint8Array(size * 1e6)]) });
    await store.saveScene({ id: scene, mesh: file, bootId: '', request: new Uint8Array(), savedAt: Number(scene) });
  }, [id, mesh, megabytes] as const);
  const there = (): Promise<string[]> => storing.evaluate(async () =>
    (await Promise.all([...'abx'].map((id) => window.store.companions(id)))).flat().map(({ name, size }) => `${name}: ${size}`));

  await makeScene('1', 'a', 2);
  assert.equal(await keep('a', 3), '');
  await makeScene('2', 'b', 1);
  assert.equal(await keep('b', 2), '');
  assert.equal(await keep('b', 5), ''); // replaces the 2 MB, and evicts a
  assert.deepEqual(await there(), ['5 of b.png: 5000000']);
  assert.equal(await storing.evaluate(() => window.store.keepsMesh('a')), false);
  assert.equal(await keep('b', 11), 'the browser has no room left for it');
  assert.deepEqual(await there(), ['5 of b.png: 5000000']);
  assert.equal(await keep('x', 1), ''); // beside a mesh that is not stored
  await storing.evaluate(() => window.store.forgetOld());
  assert.deepEqual(await there(), ['5 of b.png: 5000000']);
});

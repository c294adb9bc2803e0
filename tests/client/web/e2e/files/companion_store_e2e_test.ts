// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The page's store of companions in Chromium: with other versions of the page, with several windows, and with little room.
// Environment: LATTICED, CHROMIUM; LATTICED_PAGE, the folder of the page.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import type { Browser, BrowserContext, Page } from 'playwright-core';
import { closeContexts, launch, launchWithProfile, limitStorage } from '../support/browser';
import { ServerProcess } from '../support/server_process';
import type {} from '../page/harness'; // window.store

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
    return window.store.save(id, made, isBeside);
  }, [mesh, files, beside] as const);
}

/** The names and contents of the files stored beside a mesh. */
function beside(page: Page, mesh: string): Promise<string[]> {
  return page.evaluate(async (id) => {
    const files = await window.store.of(id);
    return Promise.all(files.map(async (file) => `${file.name} ${await file.text()}`));
  }, mesh);
}

/** The names of the tables in the page's database. */
function tables(page: Page): Promise<string[]> {
  return page.evaluate(() => new Promise<string[]>((resolve) => {
    const request = indexedDB.open('latticed');
    request.onsuccess = () => {
      resolve([...request.result.objectStoreNames]);
      request.result.close();
    };
  }));
}

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_PAGE!);
  browser = await launch();
});

after(async () => {
  await closeContexts();
  await server?.kill();
});

test('what an older page keeps is dropped by a newer one, which waits until the older one lets go of it', async () => {
  context = await browser.newContext();
  const old = await openBare();
  await old.evaluate(() => new Promise<void>((resolve) => {
    const request = indexedDB.open('latticed', 3);
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
  await page.evaluate(() => Object.assign(window, { saved: window.store.save('a', [new File(['A'], 'a.png')]) }));
  await page.waitForFunction(() => (window as unknown as { isBlocked?: boolean }).isBlocked);

  await old.evaluate(() => (window as unknown as { release(): void }).release());
  await page.evaluate(() => (window as unknown as { saved: Promise<void> }).saved);
  assert.deepEqual(await beside(page, 'a'), ['a.png A']);
  assert.deepEqual(await tables(page), ['companions']);
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
  const refusal = await page.evaluate(() => window.store.save('a', []).catch((error: Error) => error.message));
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

/** Saves files of this many megabytes beside a mesh, in place of all. Returns the refusal, or nothing. */
function keep(page: Page, mesh: string, ...megabytes: readonly number[]): Promise<string> {
  return page.evaluate(async ([id, sizes]) => {
    const files = sizes.map((size) => new File([new Uint8Array(size * 1e6)], `${size} of ${id}.png`));
    return window.store.save(id, files).then(() => '', (error: Error) => error.message);
  }, [mesh, megabytes] as const);
}

/** The names and sizes of all files that are kept. The files are not read: Chromium frees no room of a file that a page has. */
function there(page: Page): Promise<string[]> {
  return page.evaluate(() => new Promise<string[]>((resolve) => {
    const request = indexedDB.open('latticed');
    request.onsuccess = () => {
      const keys = request.result.transaction('companions').objectStore('companions').getAllKeys();
      keys.onsuccess = () => resolve((keys.result as [string, number, string, number][]).map(([, , name, size]) => `${name}: ${size}`));
      request.result.close(); // takes effect after the transaction
    };
  }));
}

test('where there is no room, what was kept first is forgotten, and none in vain', async (t) => {
  const page = await (await launchWithProfile(t)).newPage();
  await page.goto(server.origin);
  await limitStorage(page, 10e6);

  assert.equal(await keep(page, 'a', 3), '');
  assert.equal(await keep(page, 'b', 2, 1), '');
  assert.equal(await keep(page, 'c', 5), ''); // evicts a
  assert.deepEqual(await there(page), ['2 of b.png: 2000000', '1 of b.png: 1000000', '5 of c.png: 5000000']);
  assert.equal(await keep(page, 'a', 11), 'the browser has no room left for it'); // b and c together take 8 MB
  assert.deepEqual(await there(page), ['2 of b.png: 2000000', '1 of b.png: 1000000', '5 of c.png: 5000000']);
  assert.equal(await keep(page, 'c', 2), ''); // in place of the 5 MB
  assert.equal(await keep(page, 'a', 5), ''); // evicts b
  assert.deepEqual(await there(page), ['5 of a.png: 5000000', '2 of c.png: 2000000']);
});

test('the pictures of the 16 meshes that got theirs last are kept', async (t) => {
  context = await browser.newContext();
  t.after(() => context.close());
  const page = await openHarness();
  const meshes = Array.from('abcdefghijklmnop');
  for (const mesh of meshes) await save(page, mesh, [['a.png', mesh]], false);
  await save(page, 'a', [['b.png', 'newer']], true);

  await save(page, 'q', [['a.png', 'q']], false);

  assert.deepEqual(await beside(page, 'a'), ['a.png a', 'b.png newer']);
  assert.deepEqual(await beside(page, 'b'), []); // the first, after a got another
  for (const mesh of [...meshes.slice(2), 'q']) assert.deepEqual(await beside(page, mesh), [`a.png ${mesh}`]);
});

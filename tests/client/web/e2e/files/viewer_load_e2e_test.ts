// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What Chromium loads for the viewer: bytes in a first visit, and in the next one; answers of the server for a scene; decoders.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import type { BrowserContext, Page } from 'playwright-core';
import { uploadMesh } from '@src/wire/upload';
import { openPage } from '../support/browser';
import { followsDefinition } from '../support/definition';
import { browser, direct, OBJ, openTorus, page, server, setView, until, useStage } from '../support/stage';
import { createScene, dropFiles, live, meshUploaded } from '../support/viewer_page';

const SCENE = 'a-scene-to-load';
const TETRAHEDRON = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n';
const MOST_BYTES = 400_000; // 1,344,514 as they are, 309,000 in Brotli

interface LoadedFile {
  readonly name: string;
  readonly bytes: number; // as the browser uses it
  readonly body: number; // as it was sent once
  readonly transfer: number; // in this visit, with the head of the answer; 0 from the browser's cache
}

/** Opens the scene, and returns the page and the files that this window has loaded. */
async function visit(context: BrowserContext): Promise<LoadedFile[]> {
  const page = await context.newPage();
  await page.goto(`${server.origin}/?scene=${SCENE}`);
  await page.waitForFunction(() => (window.latticed?.scene?.session.surface.patchCount ?? 0) > 0);
  const files = () => filesOf(page);
  await until(async () => (await files()).some(({ name }) => name.startsWith('decode_worker')), () => 'no worker');
  const loaded = await files();
  await page.close();
  return loaded;
}

function filesOf(page: Page): Promise<LoadedFile[]> {
  return page.evaluate(() => {
    const entries = [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')] as PerformanceResourceTiming[];
    return entries
      .filter(({ name }) => /\/(assets\/[^/]*|\?scene=.*)$/.test(name))
      .map((entry) => ({
        name: entry.name.includes('?') ? 'index.html' : entry.name.replace(/.*\//, ''),
        bytes: entry.decodedBodySize, body: entry.encodedBodySize, transfer: entry.transferSize,
      }));
  });
}

const sum = (numbers: readonly number[]): number => numbers.reduce((total, each) => total + each, 0);

useStage({
  begin: async () => {
    const mesh = await uploadMesh(direct, { format: MeshFormat.OBJ }, new Blob([OBJ]));
    await direct.scenes.createScene({ mesh: mesh.id, sceneId: SCENE });
  },
});

test('a first visit loads compressed files, and the next one only asks whether the page has changed', async () => {
  const context = await browser.newContext();

  const first = await visit(context);
  const next = await visit(context);

  const kinds = new Set(first.map(({ name }) => name.replace(/-[0-9A-Z]{8}\./, '.')));
  assert.deepEqual(kinds, new Set(['index.html', 'main.js', 'style.css', 'decoder.wasm', 'decode_worker.js']));
  for (const { name, bytes, body } of first) assert.ok(body > 0 && body < bytes, `${name} has ${bytes} bytes, sent as ${body}`);
  const sent = sum(first.map(({ transfer }) => transfer));
  assert.ok(sent < MOST_BYTES, `the first visit loads ${sent} bytes`);
  for (const { name, transfer } of next) {
    if (name === 'index.html') assert.ok(transfer > 0 && transfer < 1000, `${name} takes ${transfer} bytes again`);
    else assert.equal(transfer, 0, `${name} is loaded again`);
  }
  await context.close();
});

test('a scene of a dropped mesh is described once, and its mesh not again', async () => {
  const asked: string[] = [];
  page.on('request', (request) => asked.push(request.url().replace(/.*\//, '')));

  await openTorus();
  await until(() => page.evaluate(() => window.latticed.scene!.session.status.state === 'live'));
  await page.waitForTimeout(500); // a call too many would come after the surface

  const count = (name: string): number => asked.filter((each) => each === name).length;
  // One scene is the fit preview's.
  assert.deepEqual([count('CreateScene'), count('GetScene'), count('GetMesh')], [2, 1, 0], `${asked}`);
});

test('a browser without SIMD decodes by draco3d', async () => {
  const { page: old } = await openPage(browser, server.origin);
  // To such a browser the module is as invalid as this one.
  await old.route('**/decoder-*.wasm', (route) => route.fulfill({ body: Buffer.from('\0asm\x01\0\0\0\xff', 'latin1') }));
  const loaded = old.waitForResponse('**/draco_decoder-*.wasm');
  await dropFiles(old, [['tetrahedron.obj', TETRAHEDRON]]);
  await setView({ encoding: 'draco', segments: 4 }, old);
  await createScene(old);
  await live(old);

  assert.ok((await loaded).ok());
  await old.waitForFunction(() => (window.latticed.scene!.session.surface.grid?.positionBits ?? 0) > 0);
  await followsDefinition(old, TETRAHEDRON);
  await old.close();
});

test('a decoder that cannot be fetched is said, and fetched with the next scene; its name is in the title and on the start page', async () => {
  const { page: fresh } = await openPage(browser, server.origin);
  await fresh.route('**/decoder-*.wasm', (route) => route.abort());
  await dropFiles(fresh, [['tetrahedron.obj', TETRAHEDRON]]);
  await meshUploaded(fresh);
  await fresh.getByRole('button', { name: 'Create scene' }).click();
  await fresh.locator('.fit .error').getByText(/^decoder-\w+\.wasm cannot be fetched: no answer\.$/).waitFor();
  await fresh.unrouteAll({ behavior: 'wait' });
  // A newer server has files with other hashes in their names.
  await fresh.route('**/decoder-*.wasm', (route) => route.fulfill({ status: 404 }));
  await fresh.getByRole('button', { name: 'Create scene' }).click();
  await fresh.locator('.fit .error').getByText('The server has been updated: reload the page.').waitFor();
  await fresh.unrouteAll({ behavior: 'wait' });

  await createScene(fresh);

  await live(fresh);
  const id = await fresh.evaluate(() => window.latticed.scene!.session.sceneId);
  assert.equal(await fresh.title(), 'tetrahedron · latticed');
  await fresh.goto(server.origin);
  await fresh.getByRole('group', { name: 'Recent scenes' }).getByRole('button', { name: 'tetrahedron' }).click();
  await live(fresh);
  assert.equal(await fresh.evaluate(() => window.latticed.scene!.session.sceneId), id);
  assert.equal(await fresh.locator('.scene-name').textContent(), 'tetrahedron');
  await fresh.close();
});

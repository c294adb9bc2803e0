// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Files dropped beside a mesh, in the viewer in Chromium: after a reload, in other windows and in other browsers.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import { latticeToJson } from '@src/wire/lattice_json';
import { randomId } from '@src/wire/ids';
import { uploadMesh } from '@src/wire/upload';
import { limitStorage, openPage } from '../support/browser';
import { lookAtColours, paint, quarters, squareGlb } from './colours';
import { withData } from '../support/restarts';
import { sheetObj } from '../support/sheet';
import { browser, direct, errors, page, server, until, useStage } from '../support/stage';
import { createScene, dropFiles, latticeIn, live } from '../support/viewer_page';

let picture: Buffer; // red green above blue white
let other: Buffer; // white blue above green red

useStage({
  serverOptions: withData(),
  begin: async () => {
    picture = await paint(page, 'red', 'lime', 'blue', 'white');
    other = await paint(page, 'white', 'blue', 'lime', 'red');
  },
});

/** Waits until this browser keeps a picture beside the open mesh. Returns the names of all files kept beside it. */
async function keptBeside(of: Page, name: string, content: Buffer): Promise<string[]> {
  const names = await until(() => of.evaluate(async ([picture, base64]) => {
    const { services, opener } = window.latticed;
    const companions = await services.keptCompanions((opener as unknown as { mesh: { id: string } }).mesh.id);
    const bytes = await companions.find((file) => file.name === picture)?.arrayBuffer();
    if (bytes === undefined || btoa(String.fromCharCode(...new Uint8Array(bytes))) !== base64) return undefined;
    return companions.map((file) => file.name);
  }, [name, content.toString('base64')] as const));
  return names!;
}

/** A material with the picture squares.png. */
const MTL = 'newmtl all\nmap_Kd squares.png\n';

function materialSheet(): string {
  return sheetObj((quad) => (quad === 0 ? 'usemtl all' : ''));
}

test('pictures dropped beside an OBJ are shown after a restart of the server', async () => {
  await dropFiles(page, [['sheet.mtl', MTL], ['squares.png', other], ['sheet.obj', materialSheet()]]);
  await createScene(page);
  await lookAtColours(page);
  await dropFiles(page, [['squares.png', picture]]); // replaces the picture before
  await keptBeside(page, 'squares.png', picture);

  const address = page.url();
  await page.goto('about:blank');
  await server.kill();
  await server.restart();
  await page.goto(address);
  await live(page);
  await comesTo(page, 'red green blue white');
});

test('a picture that is dropped after a reload, before the mesh is here again, is kept beside the others', async () => {
  let release!: () => void;
  const released = new Promise<void>((resolve) => (release = resolve));
  await page.route('**/GetMesh', (route) => void released.then(() => route.continue()));
  await page.reload();
  await live(page);

  await dropFiles(page, [['squares.png', other]]);
  assert.deepEqual(await keptBeside(page, 'squares.png', other), ['sheet.mtl', 'squares.png']);
  await comesTo(page, 'white blue green red');
  release();
  await page.unrouteAll({ behavior: 'wait' });
});

/** Drops the sheet, alone or with `picture`, and waits until it is shown. */
async function openSheet(of: Page, isPictured: boolean): Promise<void> {
  const pictures = isPictured ? [['sheet.mtl', MTL], ['squares.png', picture]] as const : [];
  await dropFiles(of, [...pictures, ['sheet.obj', materialSheet()]]);
  await createScene(of);
  if (isPictured) await lookAtColours(of);
}

/** Waits until the sheet has these colours. At first it may still show the picture before. */
async function comesTo(of: Page, colours: string): Promise<void> {
  await lookAtColours(of);
  await until(async () => (await quarters(of)) === colours, async () => `${await quarters(of)} is not ${colours}`);
}

const colouringOf = (of: Page): Promise<string> => of.evaluate(() => window.latticed.settings.value.colouring);

test('a picture that is dropped before the server has told which mesh the scene has is shown and kept', async (t) => {
  const { page: fresh, errors: freshErrors } = await openPage(browser, server.origin);
  t.after(() => fresh.close());
  await openSheet(fresh, true);
  await keptBeside(fresh, 'squares.png', picture);
  let asked = 0;
  let release!: () => void;
  const released = new Promise<void>((resolve) => (release = resolve));
  await fresh.route('**/GetScene', (route) => void (asked++ === 0 ? route.abort() : released.then(() => route.continue())));
  await fresh.reload();
  await live(fresh);
  assert.equal(await fresh.evaluate(() => (window.latticed.opener as unknown as { mesh: { id: string } }).mesh.id), '');

  await dropFiles(fresh, [['squares.png', other]]);
  await fresh.waitForFunction(() => window.latticed.settings.value.colouring === 'texture');
  release();
  await fresh.unrouteAll({ behavior: 'wait' });

  assert.deepEqual(await keptBeside(fresh, 'squares.png', other), ['sheet.mtl', 'squares.png']);
  await comesTo(fresh, 'white blue green red');
  assert.deepEqual(await fresh.locator('.toast-error').allInnerTexts(), []);
  freshErrors.length = 0; // the first call for the scene failed
});

test('pictures that are dropped in one window come to the browser\'s other windows of the mesh, but not in place of another look', async (t) => {
  const context = await browser.newContext({ viewport: { width: 480, height: 360 } });
  t.after(() => context.close());
  const [first, second, third] = [await context.newPage(), await context.newPage(), await context.newPage()];
  await first.goto(server.origin);
  await openSheet(first, false);
  for (const window of [second, third]) {
    await window.goto(first.url());
    await live(window);
  }
  await third.evaluate(() => window.latticed.settings.set({ colouring: 'displacement' }));

  await dropFiles(first, [['sheet.mtl', MTL], ['squares.png', picture]]);
  await comesTo(second, 'red green blue white');
  await dropFiles(second, [['squares.png', other]]);
  await comesTo(first, 'white blue green red');
  await comesTo(second, 'white blue green red');

  assert.equal(await colouringOf(third), 'displacement');
  await third.evaluate(() => window.latticed.settings.set({ colouring: 'texture' }));
  await comesTo(third, 'white blue green red');
});

test('a GLB above 64 MiB that another browser uploaded is shown plain, says where its colours are, and has them on demand', async (t) => {
  const header = { name: 'large.glb', format: MeshFormat.GLB };
  const mesh = await uploadMesh(direct, header, new Blob([new Uint8Array(squareGlb(picture, 64 << 20))]));
  const sceneId = randomId();
  await direct.scenes.createScene({ sceneId, mesh: mesh.id, lattices: [{ source: { case: 'fit', value: {} } }] });

  const { page: elsewhere, errors: errorsElsewhere } = await openPage(browser, `${server.origin}/?scene=${sceneId}`);
  t.after(() => elsewhere.close());
  const told = elsewhere.getByText('The colours of this mesh are inside its file of 67.1 MB: choose the texture to fetch it.');
  await Promise.all([live(elsewhere), told.waitFor()]); // it leaves after some seconds, in which few frames may be drawn
  assert.equal(await colouringOf(elsewhere), 'plain');

  await elsewhere.keyboard.press('n'); // opens the panel
  await elsewhere.getByLabel('Colour', { exact: true }).selectOption('texture');
  await comesTo(elsewhere, 'red green blue white');
  assert.deepEqual(errorsElsewhere, []);
});

test('a mesh that is dropped again alone has what was dropped beside it before; with other pictures it has these alone', async () => {
  await dropFiles(page, [['sheet.obj', materialSheet()]]);
  await createScene(page);
  await comesTo(page, 'white blue green red');

  await dropFiles(page, [['sheet.obj', materialSheet()], ['sole.png', picture]]);
  await createScene(page);
  assert.deepEqual(await keptBeside(page, 'sole.png', picture), ['sole.png']);
  await page.reload();
  await live(page);
  await comesTo(page, 'red green blue white');
});

test('another browser shows a mesh without what was dropped beside it, and says so where its texture is chosen', async () => {
  const { page: elsewhere } = await openPage(browser, page.url());
  await live(elsewhere);
  assert.equal(await colouringOf(elsewhere), 'plain');

  await elsewhere.keyboard.press('n'); // opens the panel
  await elsewhere.getByLabel('Colour', { exact: true }).selectOption('texture');
  await elsewhere.getByText('This browser has no pictures for sheet.obj, and shows a grid. Pictures dropped in another browser are only there.').waitFor();
  await lookAtColours(elsewhere); // the grid
  await elsewhere.close();
});

test('a GLB is shown with its own pictures in other browsers', async () => {
  await dropFiles(page, [['sheet.glb', squareGlb(picture)]]);
  await createScene(page);
  await lookAtColours(page);

  const { page: elsewhere } = await openPage(browser, page.url());
  await live(elsewhere);
  await comesTo(elsewhere, 'red green blue white');
  await elsewhere.close();
});

test('pictures that the browser has no room for are shown, and it is said that they are not kept', async () => {
  const { page: full } = await openPage(browser, server.origin);
  await limitStorage(full, 1e5);

  const filling = '#'.repeat(300_000);
  await dropFiles(full, [['sheet.obj', `${sheetObj()}\n${filling}`], ['squares.png', picture], ['sheet.mtl', filling]]);
  await createScene(full);

  await full.locator('.toast-error').getByText(
    'The files dropped with this mesh will be missing after a reload: the browser has no room left for it.').waitFor();
  await comesTo(full, 'red green blue white');
  await full.context().grantPermissions(['clipboard-write']);
  await full.evaluate(() => window.latticed.commands.get('copy-link').run());
  await full.getByText('The link is copied. Everyone with access to this server edits the same scene by it. Files dropped with the mesh stay on this page.').waitFor();
  await full.close();
});

test('a lattice of another frame leaves the mesh in its colours', async () => {
  const lattice = latticeIn([[-1.5, -1.5, -1], [3, 0, 0], [0, 3, 0], [0, 0, 2]], 2, 1);

  await dropFiles(page, [['lattice.json', latticeToJson(lattice)]]);
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.size.join() === '2,2,2');
  await live(page);
  await comesTo(page, 'red green blue white');
  assert.deepEqual(errors, []);
});

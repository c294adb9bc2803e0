// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Files that the viewer in Chromium opens, chosen or dropped, and that it downloads. Uses tokens and TLS.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import type { Page } from 'playwright-core';
import { latticeToJson } from '@src/wire/lattice_json';
import { distance, sub } from '@src/lattice/vec';
import { openPage } from '../support/browser';
import { sheetObj } from '../support/sheet';
import { browser, errors, page, press, select, server, shot, useStage } from '../support/stage';
import { TOKENS, tokenOptions } from '../support/tokens';
import { controlPoint, createScene, dropFiles, latticeIn, live, meshUploaded, saved } from '../support/viewer_page';

/** A PNG file of one grey pixel. */
const DOT = Buffer.from('iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR42mNoAAAAggCB2kUIOwAAAABJRU5ErkJggg==', 'base64');

const folder = mkdtempSync(join(tmpdir(), 'latticed-viewer-'));
let draco: { bytes: Buffer; faces: number };

/** Chooses files in the browser's file dialog, which `open` opens. */
async function choose(files: readonly (readonly [name: string, content: string | Buffer])[], open: () => Promise<void>): Promise<void> {
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), open()]);
  await chooser.setFiles(files.map(([name, content]) => ({ name, mimeType: '', buffer: Buffer.from(content) })));
}

/** Downloads a format of the open export dialog. */
async function exported(format: string): Promise<{ name: string; bytes: Buffer }> {
  const [download] = await Promise.all([
    page.waitForEvent('download'), page.locator('.export-choice', { hasText: format.toUpperCase() }).click()]);
  await page.locator('.export').waitFor({ state: 'detached' });
  return { name: download.suggestedFilename(), bytes: await saved(download) };
}

const [certificate, key] = [join(folder, 'server.crt'), join(folder, 'server.key')];
execFileSync('openssl', [
  'req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2', '-subj', '/CN=127.0.0.1',
  '-addext', 'subjectAltName=IP:127.0.0.1', '-keyout', key, '-out', certificate], { stdio: 'ignore' });

/** So little memory as below does not hold encoders for patches of many sizes. */
function bySegments(of: Page): Promise<void> {
  return of.evaluate(() => window.latticed.settings.set({ detail: 'segments' }));
}

useStage({
  serverOptions: [...tokenOptions(folder), '--tls-cert', certificate, '--tls-key', key,
    '--memory', '24MiB', '--max-mesh-bytes', '1MiB', '--caller-share', '1'],
  address: () => `${server.origin}/#token=${TOKENS.edit}`,
  begin: async () => {
    page.on('filechooser', () => {}); // early, so that no dialog is missed
    await bySegments(page);
  },
});
after(() => rmSync(folder, { recursive: true }));

test('what is too large for the server is refused in words: how much it is, and how much there is', async () => {
  await dropFiles(page, [['large.obj', '#'.repeat(1_200_000)]]);
  const toast = page.locator('.toast-error');
  await toast.getByText('large.obj is too large for the server: it has 1.20 MB, and the limit is 1.05 MB.').waitFor();
  await shot('viewer_too_large');
  await toast.getByRole('button', { name: 'Close' }).click();

  await page.locator('[data-sample=knot]').click();
  await page.getByText('5,760 faces').waitFor();
  for (const axis of ['u', 'v', 'w']) await page.getByLabel(`Points along ${axis}`).fill('30');
  await page.getByRole('button', { name: 'Create scene' }).click();
  const error = page.locator('.fit .error');
  await error.getByText(/^Too large for the server: \S+ MB of memory are needed for the scene's plan, and \S+ MB are free\.$/).waitFor();
  await shot('viewer_no_memory');
  await page.getByRole('button', { name: 'Cancel' }).click();
  errors.length = 0; // the console reports the refused call too
});

/** A tetrahedron, 1 unit wide. */
function tetrahedronStl(): string {
  const corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map((facet) =>
    `facet normal 0 0 0\nouter loop\n${facet.map((i) => `vertex ${corners[i].join(' ')}`).join('\n')}\nendloop\nendfacet`);
  return `solid one\n${facets.join('\n')}\nendsolid one\n`;
}

/** Waits until the dialog shows the tetrahedron, creates its scene, and checks the bounds of its surface. */
async function tetrahedronShown(): Promise<void> {
  await page.getByText('tetrahedron.stl: 4 vertices, 4 faces, 1 × 1 × 1').waitFor();
  await createScene(page);

  const bounds = await page.evaluate(() => {
    const { min, max } = window.latticed.scene!.session.surface.bounds;
    return [...min.toArray(), ...max.toArray()];
  });
  bounds.forEach((x, i) => assert.ok(Math.abs(x - Math.floor(i / 3)) < 1e-3, `${bounds}`));
}

test('an STL file that the button\'s dialog chooses becomes a scene', async () => {
  await choose([['tetrahedron.stl', tetrahedronStl()]], () => page.getByRole('button', { name: 'Open a mesh' }).click());

  await tetrahedronShown();
});

test('an OBJ file and its picture are chosen together, by the key', async () => {
  await choose([['sheet.obj', sheetObj()], ['dot.png', DOT]], () => page.keyboard.press('Control+o'));

  await page.getByText('sheet.obj: 25 vertices, 16 faces, 2 × 2 × 0').waitFor();
  await createScene(page);
  await page.waitForFunction(() => window.latticed.settings.value.colouring === 'texture');
});

test('every format is downloaded with the token of the page, which a reload keeps and the shared link does not hold', async () => {
  const patches = await page.evaluate(() => window.latticed.scene!.session.surface.patchCount);
  const magic: Record<string, (bytes: Buffer) => boolean> = {
    glb: (bytes) => bytes.toString('latin1', 0, 4) === 'glTF' && bytes.readUInt32LE(8) === bytes.length,
    ply: (bytes) => bytes.toString('latin1', 0, 4) === 'ply\n',
    obj: (bytes) => /^f /m.test(bytes.toString()),
    usda: (bytes) => bytes.toString('latin1', 0, 9) === '#usda 1.0',
    stl: (bytes) => 84 + 50 * bytes.readUInt32LE(80) === bytes.length,
    drc: (bytes) => bytes.toString('latin1', 0, 5) === 'DRACO',
    nets: (bytes) => bytes.toString('latin1', 0, 8) === 'LATTNETS' && 32 + 24 * bytes.readUInt32LE(16) * patches === bytes.length,
  };
  for (const [format, isOne] of Object.entries(magic)) {
    await page.keyboard.press('Control+e');
    const { name, bytes } = await exported(format);

    assert.ok(isOne(bytes), format);
    assert.match(name, new RegExp(`\\.${format}$`));
  }
  assert.deepEqual(errors, []);

  await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  await page.evaluate(() => window.latticed.commands.get('copy-link').run());
  await page.getByText('The link is copied. Everyone with access to this server edits the same scene by it. Files dropped with the mesh stay in this browser.').waitFor();
  const link = await page.evaluate(() => navigator.clipboard.readText());
  assert.match(link, /\?scene=[0-9a-f]{32}$/);
  const [socket] = await Promise.all([page.waitForEvent('websocket'), page.reload()]);
  await live(page);
  assert.match(socket.url(), /^wss:\/\/127\.0\.0\.1:.*\/ws\/latticed\.v1\.SceneService\/Deform\?/);
});

test('an export has the segments and normals that the page shows, or the segments that its dialog is told', async () => {
  const patches = await page.evaluate(() => window.latticed.scene!.session.surface.patchCount);
  await page.keyboard.press('n'); // opens the panel
  await page.getByLabel('Normals', { exact: true }).selectOption('none');
  await page.getByRole('slider', { name: 'Segments' }).fill('3');
  await page.keyboard.press('n');

  await page.keyboard.press('Control+e');
  await page.getByText(`${9 * patches} triangles, no normals`).waitFor();
  assert.doesNotMatch(await page.locator('.export').innerText(), /with normals/);
  await shot('viewer_export');
  const { bytes: ply } = await exported('ply');
  await page.keyboard.press('Control+e');
  await page.getByRole('spinbutton', { name: 'Segments' }).fill('33');
  await page.getByText('Segments are 1 to 32.').waitFor();
  assert.equal(await page.locator('.export-choice:enabled').count(), 0);
  await page.getByRole('spinbutton', { name: 'Segments' }).fill('2');
  await page.getByText(`${4 * patches} triangles, no normals`).waitFor();
  const { bytes: stl } = await exported('stl');

  const head = ply.toString('latin1', 0, ply.indexOf('end_header'));
  assert.match(head, new RegExp(`element face ${9 * patches}\n`));
  assert.doesNotMatch(head, /nx/);
  assert.equal(stl.readUInt32LE(80), 4 * patches);
  await page.keyboard.press('Control+e');
  await page.getByRole('spinbutton', { name: 'Segments' }).fill('2');
  draco = { bytes: (await exported('drc')).bytes, faces: 4 * patches };
  await page.keyboard.press('Control+e');
  const [same] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]); // the last format again
  assert.match(same.suggestedFilename(), /\.drc$/);
  await page.locator('.export').waitFor({ state: 'detached' });
  assert.equal(await page.evaluate(() => window.latticed.settings.value.view.segments), 3); // the view does not change
});

test('an export by tolerance has points only where the surface bends, and the dialog remembers the tolerance', async () => {
  const [patches, diagonal] = await page.evaluate(() => {
    const { patchCount, bounds } = window.latticed.scene!.session.surface;
    return [patchCount, bounds.min.distanceTo(bounds.max)];
  });
  await page.keyboard.press('Control+e');
  await page.getByRole('radio', { name: 'By tolerance' }).click();
  const tolerance = page.getByRole('spinbutton', { name: 'Tolerance' });
  assert.equal(Number(await tolerance.inputValue()), Number((1e-4 * diagonal).toPrecision(3)));
  await page.getByText(/^Within \S+ \S+ of the exact surface, 0\.0001 of its diagonal; no normals$/).waitFor();
  await tolerance.fill('-1');
  await page.getByText('The tolerance is a length.').waitFor();
  assert.equal(await page.locator('.export-choice:enabled').count(), 0);
  await tolerance.fill('0.02');
  const message = page.locator('.toast').getByText(/\.stl is within \S+ \S+ of the exact surface, at any point\.$/);
  const [stl, told] = await Promise.all([exported('stl'), message.innerText()]); // it leaves after some seconds
  const faces = stl.bytes.readUInt32LE(80);
  assert.ok(faces >= patches && faces < 9 * patches, `${faces} triangles of ${patches} patches`);
  assert.ok(Number(/within (\S+)/.exec(told)![1]) <= 0.02, told);

  await page.keyboard.press('Control+e');
  assert.equal(await tolerance.inputValue(), '0.02');
  await page.getByRole('radio', { name: 'By segments' }).click();
  await exported('stl');
});

test('the original mesh is exported with its own faces, and the dialog remembers that', async () => {
  await page.keyboard.press('Control+e');
  await page.getByRole('radio', { name: 'Original mesh' }).click();
  await page.getByText('The vertices and faces of the file, moved; no normals').waitFor();
  assert.ok(await page.locator('.export-choice', { hasText: 'nets' }).isDisabled());
  assert.ok(await page.getByRole('spinbutton', { name: 'Segments' }).isDisabled());
  const obj = (await exported('obj')).bytes.toString();
  assert.deepEqual([obj.match(/^v /gm)?.length, obj.match(/^f /gm)?.length], [25, 16]);

  await page.keyboard.press('Control+e');
  assert.equal(await page.getByRole('radio', { name: 'Original mesh' }).getAttribute('aria-checked'), 'true');
  await page.getByRole('radio', { name: 'Exact surface' }).click();
  await exported('obj');
});

test('a Draco file that is dropped becomes a scene, which has no pictures to show', async () => {
  await dropFiles(page, [['sheet.drc', draco.bytes]]);
  await page.getByText(new RegExp(`^sheet\\.drc: .* vertices, ${draco.faces} faces, 2 × 2 × `)).waitFor();
  await createScene(page);

  const { min, max } = await page.evaluate(() => window.latticed.scene!.session.surface.bounds);
  assert.ok(distance([min.x, min.y, min.z], [-1, -1, 0]) < 1e-2 && distance([max.x, max.y, max.z], [1, 1, 0]) < 1e-2);
  await page.evaluate(() => window.latticed.settings.set({ colouring: 'texture' }));
  await page.getByText('Textures are shown of OBJ, PLY and GLB files, not of Draco files.').waitFor();
  assert.equal(await page.evaluate(() => window.latticed.settings.value.colouring), 'plain');
  await page.locator('.toast-error').getByRole('button', { name: 'Close' }).click();
});

test('a lattice of another frame that is chosen replaces that of the scene; transforms have its axes, and reset and undo bring shapes back', async () => {
  const scene = (): Promise<{ id: string; size: string }> =>
    page.evaluate(() => ({ id: window.latticed.scene!.session.sceneId, size: window.latticed.scene!.session.lattice.size.join() }));
  const before = await scene();
  const lattice = latticeIn([[0, -2.2, -1], [2.2, 2.2, 0], [-2.2, 2.2, 0], [0, 0, 2]], 3, 2);
  lattice.points[3 * 26 + 2] += 0.5; // the last point, which is at (0, 2.2, 1) at rest

  await choose([['lattice.json', latticeToJson(lattice)]], async () => {
    await page.locator('.menu-button').getByText('File', { exact: true }).click();
    await page.getByRole('menuitem', { name: 'Open lattice…' }).click();
  });
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.size.join() === '3,3,3');
  assert.equal((await scene()).id, before.id);
  await select(26);
  const rest = await controlPoint(page, 26);
  await press(',', 'g', 'x', '1', 'Enter');

  const moved = sub(await controlPoint(page, 26), rest);
  assert.ok(distance(moved, [Math.SQRT1_2, Math.SQRT1_2, 0]) < 1e-9, `${moved}`);
  for (const [reset, z] of [['Reset to the first lattice', 1.5], ['Reset to rest', 1]] as const) {
    await page.locator('.menu-button').getByText('Edit', { exact: true }).click();
    await page.getByRole('menuitem', { name: reset }).click();
    await page.waitForFunction((height) => {
      const [x, y, at] = window.latticed.scene!.session.lattice.points.slice(3 * 26);
      return Math.hypot(x, y - 2.2, at - height) < 1e-9;
    }, z);
  }
  for (let undone = 0; undone < 4; ++undone) await press('Control+z'); // both resets, the move, the lattice
  await page.waitForFunction((size) => window.latticed.scene!.session.lattice.size.join() === size, before.size);
});

test('size and degree are changed in the scene: the shape stays as well as it can, and the page says how far it changed', async () => {
  const resize = async (points: string, degree: string): Promise<void> => {
    await page.locator('.menu-button').getByText('Edit', { exact: true }).click();
    await page.getByRole('menuitem', { name: 'Size and degree…' }).click();
    for (const axis of ['u', 'v', 'w']) {
      await page.getByLabel(`Points along ${axis}`).fill(points);
      await page.getByLabel(`Degree along ${axis}`).selectOption(degree);
    }
  };
  await resize('3', '3');
  await page.getByText('Along u, degree 3 needs at least 4 control points.').waitFor();
  assert.ok(await page.getByRole('button', { name: 'Change' }).isDisabled());
  await page.getByRole('button', { name: 'Cancel' }).click();

  await page.evaluate(() => window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(0), offset: [-0.5, 0, 0] }));
  await resize('6', '2'); // the knots of 4 points are among those of 6
  await page.getByRole('button', { name: 'Change' }).click();
  await page.getByText('The new lattice keeps the shape.').waitFor();
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.size.join() === '6,6,6');
  await resize('2', '1');
  await page.getByRole('button', { name: 'Change' }).click();
  await page.getByText(/^The new lattice changes the shape by about 0\.\d+ units\.$/).waitFor();
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.degree.join() === '1,1,1');
});

/** Drops a mesh whose upload does not end before the function returned is called. */
async function dropHeld(): Promise<() => Promise<void>> {
  let release!: () => void;
  const released = new Promise<void>((resolve) => (release = resolve));
  await page.route('**/FinishUpload', (route) => void released.then(() => route.continue()));
  const finished = page.waitForRequest('**/FinishUpload');
  await dropFiles(page, [['tetrahedron.stl', tetrahedronStl()]]);
  await finished;
  return async () => {
    release();
    await page.unrouteAll({ behavior: 'wait' });
  };
}

test('the button that creates has the focus when the mesh is there, but not in place of a field that somebody is at', async () => {
  const field = page.getByLabel('Points along v');
  for (const isUsed of [false, true]) {
    const release = await dropHeld();
    if (isUsed) await field.click();
    await release();
    await meshUploaded(page);

    const focused = isUsed ? field : page.getByRole('button', { name: 'Create scene' });
    assert.ok(await focused.evaluate((element) => element === document.activeElement));
    await page.getByRole('button', { name: 'Cancel' }).click();
    await page.locator('dialog.fit').waitFor({ state: 'detached' });
  }
});

test('Enter during the upload makes the scene once the mesh is there, as the dialog says; Esc makes none', async () => {
  const open = (): Promise<string> => page.evaluate(() => window.latticed.scene!.session.sceneId);
  const before = await open();
  const enter = async (): Promise<() => Promise<void>> => {
    const release = await dropHeld();
    await page.keyboard.press('Enter');
    await page.locator('dialog.fit').getByText('as soon as the mesh is there').waitFor();
    return release;
  };

  const cancelled = await enter();
  await page.keyboard.press('Escape');
  await page.locator('dialog.fit').waitFor({ state: 'detached' });
  await cancelled();
  assert.equal(await open(), before);

  const release = await enter();
  await release();
  await page.waitForFunction((id) => window.latticed.scene!.session.sceneId !== id, before);
  await page.locator('dialog.fit').waitFor({ state: 'detached' });
});

test('of two scenes the one that was asked for last is shown, also where the other one answers later', async () => {
  const scenes = [new URL(page.url()).search];
  await dropFiles(page, [['tetrahedron.stl', tetrahedronStl()]]);
  await createScene(page);
  scenes.push(new URL(page.url()).search);
  const { page: fresh, errors: freshErrors } = await openPage(browser, `${server.origin}/#token=${TOKENS.edit}`);
  await bySegments(fresh);
  const ask = (search: string): Promise<void> => fresh.evaluate((to) => {
    history.pushState(null, '', to + location.hash);
    window.dispatchEvent(new PopStateEvent('popstate'));
  }, search);
  const isShown = (search: string): Promise<boolean> =>
    fresh.evaluate((of) => of.endsWith(window.latticed.scene!.session.sceneId), search);
  for (const isAlreadyShown of [false, true]) {
    let release!: () => void;
    const released = new Promise<void>((resolve) => (release = resolve));
    await fresh.route('**/GetScene', (route) => void released.then(() => route.continue()), { times: 1 });
    const asked = fresh.waitForRequest('**/GetScene');
    await ask(scenes[0]);
    await asked;
    if (isAlreadyShown) assert.ok(await isShown(scenes[1]));
    await ask(scenes[1]);
    await live(fresh);
    const [late] = await Promise.all([fresh.waitForEvent('websocket'), release()]);
    await late.waitForEvent('close');

    assert.ok(await isShown(scenes[1]));
    assert.equal(await fresh.locator('.connection').getAttribute('data-state'), 'live');
  }
  assert.deepEqual(freshErrors, []);
  await fresh.close();
});

test('a download that fails is said in the dialog', async () => {
  await page.keyboard.press('Control+e');
  await server.kill();

  await page.locator('.export-choice', { hasText: 'PLY' }).click();

  await page.locator('.export .error').getByText('The server cannot be reached.').waitFor();
});

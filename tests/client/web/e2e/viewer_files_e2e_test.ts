// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Files in and out of the viewer in Chromium: pictures on meshes, downloads, and both with tokens.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { latticeFromJson, latticeToJson } from '@src/lattice/lattice_json';
import { distance, sub, type Vec3 } from '@src/lattice/vec';
import { launch, openPage } from './browser';
import { ServerProcess } from './server_process';
import { colourAt, controlPoint, createScene, dropFiles, live } from './viewer_page';

const TOKENS = { edit: 'let-me-edit', read: 'let-me-look' } as const;

const folder = mkdtempSync(join(tmpdir(), 'latticed-viewer-'));
let server: ServerProcess;
let browser: Browser;
let page: Page;
let errors: string[];
let picture: Buffer;

/** A sheet over -1 to 1 whose texture coordinates go from 0 to 1, u right and v up: 16 quads. */
const sheet = Array.from({ length: 5 }, (_, j) => Array.from({ length: 5 }, (__, i) => [i / 4, j / 4] as const)).flat();
const quads = Array.from({ length: 16 }, (_, q) => {
  const at = Math.floor(q / 4) * 5 + (q % 4);
  return [at, at + 1, at + 6, at + 5];
});

function sheetObj(materials: (quad: number) => string): string {
  const lines = sheet.flatMap(([u, v]) => [`v ${2 * u - 1} ${2 * v - 1} 0`, `vt ${u} ${v}`]);
  const faces = quads.flatMap((quad, q) => [materials(q), `f ${quad.map((i) => `${i + 1}/${i + 1}`).join(' ')}`]);
  return ['mtllib sheet.mtl', ...lines, ...faces].join('\n');
}

function sheetPly(): string {
  const vertices = sheet.map(([u, v]) => `${2 * u - 1} ${2 * v - 1} 0 ${u} ${v}`);
  const faces = quads.map((quad) => `4 ${quad.join(' ')}`);
  return `ply\nformat ascii 1.0\ncomment TextureFile squares.png\nelement vertex 25\nproperty float x\nproperty float y\n` +
    `property float z\nproperty float s\nproperty float t\nelement face 16\nproperty list uchar int vertex_indices\n` +
    `end_header\n${[...vertices, ...faces].join('\n')}\n`;
}

/** The sheet as one quad with the picture inside; glTF's v counts downwards. */
function sheetGlb(): Buffer {
  const positions = Float32Array.of(-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0);
  const uvs = Float32Array.of(0, 1, 1, 1, 1, 0, 0, 0);
  const indices = Uint16Array.of(0, 1, 2, 0, 2, 3);
  const bin = Buffer.concat([...[positions, uvs, indices].map(({ buffer }) => Buffer.from(buffer)), picture]);
  const view = (byteOffset: number, byteLength: number): object => ({ buffer: 0, byteOffset, byteLength });
  const json = Buffer.from(JSON.stringify({
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2, material: 0 }] }],
    materials: [{ pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }], textures: [{ source: 0 }],
    images: [{ bufferView: 3, mimeType: 'image/png' }], buffers: [{ byteLength: bin.length }],
    bufferViews: [view(0, 48), view(48, 32), view(80, 12), view(92, picture.length)],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: 'VEC3', min: [-1, -1, 0], max: [1, 1, 0] },
      { bufferView: 1, componentType: 5126, count: 4, type: 'VEC2' },
      { bufferView: 2, componentType: 5123, count: 6, type: 'SCALAR' },
    ],
  }));
  const chunk = (type: string, bytes: Buffer, fill: string): Buffer => {
    const padded = Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, fill)]);
    const head = Buffer.alloc(8);
    head.writeUInt32LE(padded.length);
    head.write(type, 4, 'latin1');
    return Buffer.concat([head, padded]);
  };
  const body = Buffer.concat([chunk('JSON', json, ' '), chunk('BIN\0', bin, '\0')]);
  const head = Buffer.alloc(12);
  head.write('glTF');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + body.length, 8);
  return Buffer.concat([head, body]);
}

/** Looks straight onto the sheet, without the cage, in its colours. */
async function lookAtColours(of: Page): Promise<void> {
  await of.evaluate(() => {
    window.latticed.settings.set({ cage: false, gizmo: 'none' });
    window.latticed.viewport.rig.lookFrom([0, -1e-3, 1]);
    window.latticed.scene!.frameAll();
  });
  await of.waitForFunction(() => (window.latticed.scene!.session.surface as unknown as { isTextured: boolean }).isTextured);
}

/** Which of red, green, blue or white a place of the sheet has. */
async function nameAt(x: number, y: number): Promise<string> {
  const [r, g, b] = await colourAt(page, [x, y, 0]);
  const most = Math.max(r, g, b);
  const strong = [r > most / 2, g > most / 2, b > most / 2].join();
  const names = { 'true,false,false': 'red', 'false,true,false': 'green', 'false,false,true': 'blue', 'true,true,true': 'white' };
  return names[strong as keyof typeof names] ?? `${[r, g, b]}`;
}

async function quarters(): Promise<string[]> {
  return [await nameAt(-0.5, 0.5), await nameAt(0.5, 0.5), await nameAt(-0.5, -0.5), await nameAt(0.5, -0.5)];
}

async function shot(name: string, of = page): Promise<void> {
  if (process.env.LATTICED_SHOTS) await of.screenshot({ path: join(process.env.LATTICED_SHOTS, `${name}.png`) });
}

/** What a format of the open dialog writes. */
async function exported(format: string): Promise<{ name: string; bytes: Buffer }> {
  const [download] = await Promise.all([
    page.waitForEvent('download'), page.locator('.export-choice', { hasText: format.toUpperCase() }).click()]);
  const parts: Buffer[] = [];
  for await (const part of await download.createReadStream()) parts.push(part as Buffer);
  await page.locator('.export').waitFor({ state: 'detached' });
  return { name: download.suggestedFilename(), bytes: Buffer.concat(parts) };
}

before(async () => {
  const tokens = Object.entries(TOKENS).map(([role, token]) => `${createHash('sha256').update(token).digest('hex')} ${role} ${role}`);
  writeFileSync(join(folder, 'tokens'), tokens.join('\n'));
  server = await ServerProcess.start(process.env.LATTICED_VIEWER!, [
    '--token-file', join(folder, 'tokens'), '--memory', '24MiB', '--max-mesh-bytes', '1MiB']);
  browser = await launch();
  ({ page, errors } = await openPage(browser, `${server.origin}/#token=${TOKENS.edit}`));
  // Red above left, green above right, blue below left, white below right.
  picture = Buffer.from(await page.evaluate(() => {
    const canvas = Object.assign(document.createElement('canvas'), { width: 64, height: 64 });
    const context = canvas.getContext('2d')!;
    ['red', 'lime', 'blue', 'white'].forEach((colour, i) => {
      context.fillStyle = colour;
      context.fillRect(32 * (i % 2), 32 * Math.floor(i / 2), 32, 32);
    });
    return canvas.toDataURL('image/png').split(',')[1];
  }), 'base64');
});

after(async () => {
  await browser?.close();
  await server?.kill();
  rmSync(folder, { recursive: true });
});

test('without a token the page says that one is wanted', async () => {
  const { page: stranger } = await openPage(browser, server.origin);

  await stranger.locator('[data-sample=slab]').click();

  await stranger.locator('.fit .error').getByText('The server wants a token').waitFor();
  await stranger.close();
});

test('what is too large for the server is refused in words: how much it is, and how much there is', async () => {
  await dropFiles(page, [['large.obj', '#'.repeat(1_200_000)]]);
  const toast = page.locator('.toast-error');
  await toast.getByText('large.obj is too large for the server: it has 1.20 MB, and 1.05 MB are the most.').waitFor();
  await shot('viewer_too_large');
  await toast.getByRole('button', { name: 'Close' }).click();

  await page.locator('[data-sample=knot]').click();
  for (const axis of ['u', 'v', 'w']) await page.getByLabel(`Points along ${axis}`).fill('30');
  await page.getByText('5,760 faces').waitFor();
  await page.getByRole('button', { name: 'Create scene' }).click();
  const error = page.locator('.fit .error');
  await error.getByText(/^Too large for the server: \S+ MB of memory are wanted for the scene's plan, and \S+ MB are free\.$/).waitFor();
  await shot('viewer_no_memory');
  await page.getByRole('button', { name: 'Cancel' }).click();
  errors.length = 0; // the refused call is in the console too
});

const DROPS: Record<string, () => [string, string | Buffer][]> = {
  'an OBJ with a picture': () => [['readme.txt', 'Fine art.'], ['squares.png', picture], ['sheet.obj', sheetObj(() => '')]],
  'a PLY with the picture that it names': () => [['Squares.png', picture], ['other.png', Buffer.from('')], ['sheet.ply', sheetPly()]],
  'a GLB with a picture inside': () => [['sheet.glb', sheetGlb()]],
};
for (const [what, files] of Object.entries(DROPS)) {
  test(`${what} is shown with it, the right way up`, async () => {
    await dropFiles(page, files());
    await createScene(page);
    await lookAtColours(page);

    assert.deepEqual(await quarters(), ['red', 'green', 'blue', 'white']);
  });
}

test('an OBJ with its MTL file has a picture and a colour by material, and a lost picture is said', async () => {
  const mtl = 'newmtl wood\nKd 1 1 1\nmap_Kd textures/squares.png\nnewmtl paint\nKd 0 0 1\nnewmtl lost\nKd 1 0 0\nmap_Kd gone.png\n';
  const material = (quad: number): string => `usemtl ${quad % 4 < 2 ? 'wood' : quad < 8 ? 'paint' : 'lost'}`;

  await dropFiles(page, [['sheet.mtl', mtl], ['sheet.obj', sheetObj(material)], ['squares.png', picture]]);
  await createScene(page);
  await lookAtColours(page);

  assert.deepEqual(await quarters(), ['red', 'red', 'blue', 'blue']);
  await page.getByText('sheet.obj names the picture gone.png, which was not dropped with it.').waitFor();
  await shot('viewer_materials');
});

test('an STL file becomes a scene', async () => {
  const corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map((facet) =>
    `facet normal 0 0 0\nouter loop\n${facet.map((i) => `vertex ${corners[i].join(' ')}`).join('\n')}\nendloop\nendfacet`);

  await dropFiles(page, [['tetrahedron.stl', `solid one\n${facets.join('\n')}\nendsolid one\n`]]);
  await page.getByText('tetrahedron.stl: 4 vertices, 4 faces, 1 × 1 × 1').waitFor();
  await createScene(page);

  const bounds = await page.evaluate(() => {
    const { min, max } = window.latticed.scene!.session.surface.bounds;
    return [...min.toArray(), ...max.toArray()];
  });
  bounds.forEach((x, i) => assert.ok(Math.abs(x - Math.floor(i / 3)) < 1e-3, `${bounds}`));
});

test('a mesh that has no texture coordinates says so, and is shown plain', async () => {
  const plain = sheetObj(() => '').replace(/^vt.*\n/gm, '').replace(/\/\d+/g, '');

  await dropFiles(page, [['plain.obj', plain], ['squares.png', picture]]);
  await createScene(page);

  await page.getByText('plain.obj has no texture coordinates.').waitFor();
  assert.equal(await page.evaluate(() => window.latticed.settings.value.colouring), 'plain');
});

test('every format is downloaded with the token of the page, which a reload keeps and the shared link does not hold', async () => {
  const magic: Record<string, (bytes: Buffer) => boolean> = {
    glb: (bytes) => bytes.toString('latin1', 0, 4) === 'glTF' && bytes.readUInt32LE(8) === bytes.length,
    ply: (bytes) => bytes.toString('latin1', 0, 4) === 'ply\n',
    obj: (bytes) => /^f /m.test(bytes.toString()),
    stl: (bytes) => 84 + 50 * bytes.readUInt32LE(80) === bytes.length,
    drc: (bytes) => bytes.toString('latin1', 0, 5) === 'DRACO',
  };
  for (const [format, isOne] of Object.entries(magic)) {
    await page.keyboard.press('Control+e');
    const { name, bytes } = await exported(format);

    assert.ok(isOne(bytes), format);
    assert.match(name, new RegExp(`\\.${format}$`));
  }
  assert.deepEqual(errors, []);

  await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  await page.evaluate(() => window.latticed.commands.get('share').run());
  await page.getByText('The link is copied').waitFor();
  const link = await page.evaluate(() => navigator.clipboard.readText());
  assert.match(link, /\?scene=[0-9a-f]{32}$/);
  await page.reload();
  await live(page);
});

test('an export has the segments and normals that the page shows, or the segments that its dialog is told', async () => {
  const patches = await page.evaluate(() => window.latticed.scene!.session.surface.patchCount);
  await page.keyboard.press('n'); // the panel
  await page.getByLabel('Normals', { exact: true }).selectOption('none');
  await page.getByRole('slider', { name: 'Segments' }).fill('3');
  await page.keyboard.press('n');

  await page.keyboard.press('Control+e');
  await page.getByText(`${9 * patches} triangles, no normals`).waitFor();
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
  assert.equal(await page.evaluate(() => window.latticed.settings.value.view.segments), 3); // what is shown stays
});

test('a lattice of another frame makes another scene of the mesh, whose axes transforms have and whose shape a reset brings back', async () => {
  const before = await page.evaluate(() => ({ id: window.latticed.scene!.session.sceneId, url: location.href }));
  const vector = ([x, y, z]: Vec3): object => ({ x, y, z });
  const frame = { origin: vector([0, -2.2, -1]), u: vector([2.2, 2.2, 0]), v: vector([-2.2, 2.2, 0]), w: vector([0, 0, 2]) };
  const lattice = latticeFromJson(JSON.stringify({ frame, size: { u: 3, v: 3, w: 3 }, degree: { u: 2, v: 2, w: 2 } }));
  lattice.points[3 * 26 + 2] += 0.5; // the last one, at (0, 2.2, 1) at rest

  await dropFiles(page, [['lattice.json', latticeToJson(lattice)]]);
  await page.waitForFunction((id) => window.latticed.scene!.session.sceneId !== id, before.id);
  await live(page);
  assert.notEqual(page.url(), before.url);
  await page.evaluate(() => window.latticed.scene!.editor.selection.select([26]));
  const rest = await controlPoint(page, 26);
  for (const key of [',', 'g', 'x', '1', 'Enter']) await page.keyboard.press(key);

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
});

test('a link to a scene that is not there is said on the page', async () => {
  const { page: lost } = await openPage(browser, `${server.origin}/?scene=0123456789abcdef0123456789abcdef#token=${TOKENS.edit}`);

  await lost.locator('.toast-error').getByText(/^The scene 0123456789abcdef0123456789abcdef could not be opened\. /).waitFor();
  await shot('viewer_no_scene', lost);
  assert.ok(await lost.getByRole('button', { name: 'Open a mesh' }).isVisible());
  await lost.close();
});

test('a token that may only look sees the scene; its edit goes back, in words', async () => {
  const { page: looker } = await openPage(browser, `${server.origin}/${new URL(page.url()).search}#token=${TOKENS.read}`);
  await live(looker);
  const before = await looker.evaluate(() => [...window.latticed.scene!.session.lattice.points]);

  await looker.keyboard.press('a');
  for (const key of ['g', 'z', '1', 'Enter']) await looker.keyboard.press(key);

  await looker.locator('.toast-error').getByText('The token of this page does not allow that').waitFor();
  assert.deepEqual(await looker.evaluate(() => [...window.latticed.scene!.session.lattice.points]), before);
  await looker.close();
});

test('a download that fails is said in the dialog', async () => {
  await page.keyboard.press('Control+e');
  await server.kill();

  await page.locator('.export-choice', { hasText: 'PLY' }).click();

  await page.locator('.export .error').getByText('The server cannot be reached.').waitFor();
});

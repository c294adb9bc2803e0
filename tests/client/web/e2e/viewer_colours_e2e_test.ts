// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Colours and pictures of dropped meshes in the viewer in Chromium.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { latticeFromJson, latticeToJson } from '@src/lattice/lattice_json';
import { launch, limitStorage, openPage } from './browser';
import { GlbMaker, SQUARE } from './glb';
import { ServerProcess } from './server_process';
import { plainSheetObj, sheetObj, sheetPly } from './sheet';
import { colourAt, createScene, dropFiles, live } from './viewer_page';

const TEXTURED = { pbrMetallicRoughness: { baseColorTexture: { index: 0 } } };
const ONE_NODE = { scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }] };

let server: ServerProcess;
let browser: Browser;
let page: Page;
let errors: string[];
let picture: Buffer; // red green above blue white
let other: Buffer; // white blue above green red

async function shot(name: string): Promise<void> {
  if (process.env.LATTICED_SHOTS) await page.screenshot({ path: join(process.env.LATTICED_SHOTS, `${name}.png`) });
}

/** Four squares of colours: above left, above right, below left, below right. */
async function paint(...colours: string[]): Promise<Buffer> {
  const png = await page.evaluate((four) => {
    const canvas = Object.assign(document.createElement('canvas'), { width: 64, height: 64 });
    const context = canvas.getContext('2d')!;
    four.forEach((colour, i) => {
      context.fillStyle = colour;
      context.fillRect(32 * (i % 2), 32 * Math.floor(i / 2), 32, 32);
    });
    return canvas.toDataURL('image/png').split(',')[1];
  }, colours);
  return Buffer.from(png, 'base64');
}

/** Looks straight onto the sheet, without the cage, in its colours. */
async function lookAtColours(of = page): Promise<void> {
  await of.evaluate(() => {
    window.latticed.settings.set({ cage: false, gizmo: 'none' });
    window.latticed.viewport.rig.lookFrom([0, -1e-3, 1]);
    window.latticed.scene!.frameAll();
  });
  await of.waitForFunction(() => (window.latticed.scene!.session.surface as unknown as { isTextured: boolean }).isTextured);
}

/** Which of red, green, blue or white a place of the sheet has. */
async function nameAt(x: number, y: number, of = page): Promise<string> {
  const [r, g, b] = await colourAt(of, [x, y, 0]);
  const most = Math.max(r, g, b);
  const strong = [r > most / 2, g > most / 2, b > most / 2].join();
  const names = { 'true,false,false': 'red', 'false,true,false': 'green', 'false,false,true': 'blue', 'true,true,true': 'white' };
  return names[strong as keyof typeof names] ?? `${[r, g, b]}`;
}

/** The colours of a square of side 2. */
async function quarters(x = 0, y = 0, of = page): Promise<string> {
  const names: string[] = [];
  for (const [dx, dy] of [[-0.5, 0.5], [0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]) names.push(await nameAt(x + dx, y + dy, of));
  return names.join(' ');
}

/** The square with a picture inside. */
function squareGlb(content = picture): Buffer {
  const glb = new GlbMaker();
  const primitives = [{ ...glb.square(), material: 0 }];
  const source = glb.image(content);
  return glb.file({ ...ONE_NODE, meshes: [{ primitives }], materials: [TEXTURED], textures: [{ source }] });
}

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_VIEWER!);
  browser = await launch();
  ({ page, errors } = await openPage(browser, server.origin));
  picture = await paint('red', 'lime', 'blue', 'white');
  other = await paint('white', 'blue', 'lime', 'red');
});

after(async () => {
  await browser?.close();
  await server?.kill();
});

const DROPS: Record<string, () => [string, string | Buffer][]> = {
  'an OBJ with a picture': () => [['readme.txt', 'Fine art.'], ['squares.png', picture], ['sheet.obj', sheetObj()]],
  'a PLY with the picture that it names': () => [['Squares.png', picture], ['other.png', Buffer.from('')], ['sheet.ply', sheetPly()]],
  'a GLB with a picture inside': () => [['sheet.glb', squareGlb()]],
};
for (const [what, files] of Object.entries(DROPS)) {
  test(`${what} is shown with it, the right way up`, async () => {
    await dropFiles(page, files());
    await createScene(page);
    await lookAtColours();

    assert.equal(await quarters(), 'red green blue white');
  });
}

test('an OBJ with its MTL file has a picture and a colour by material, and a lost picture is said', async () => {
  const mtl = 'newmtl wood\nKd 1 1 1\nmap_Kd textures/squares.png\nnewmtl paint\nKd 0 0 1\nnewmtl lost\nKd 1 0 0\nmap_Kd gone.png\n';
  const material = (quad: number): string => `usemtl ${quad % 4 < 2 ? 'wood' : quad < 8 ? 'paint' : 'lost'}`;

  await dropFiles(page, [['sheet.mtl', mtl], ['sheet.obj', sheetObj(material)], ['squares.png', picture]]);
  await createScene(page);
  await lookAtColours();

  assert.equal(await quarters(), 'red red blue blue');
  await page.getByText('sheet.obj names the picture gone.png, which was not dropped with it.').waitFor();
  await shot('viewer_materials');
});

test('a mesh that has no texture coordinates says so, and is shown plain', async () => {
  await dropFiles(page, [['plain.obj', plainSheetObj()], ['squares.png', picture]]);
  await createScene(page);

  await page.getByText('plain.obj has no texture coordinates.').waitFor();
  assert.equal(await page.evaluate(() => window.latticed.settings.value.colouring), 'plain');
});

test('a GLB has a picture for each primitive, by its transform, under the transforms of its nodes; strips too', async () => {
  const glb = new GlbMaker();
  const two = [
    { ...glb.square(), material: 0 },
    { ...glb.square({ positions: SQUARE.positions.map((x, i) => (i % 3 === 0 ? x + 2 : x)) }), material: 1 },
  ];
  const turned = glb.square({ uvs: new Float32Array(8) });
  turned.attributes.TEXCOORD_1 = glb.accessor(SQUARE.uvs, 'VEC2');
  // The left half and the right one, joined by triangles without area.
  const strip = glb.square({
    positions: Float32Array.of(-1, -1, 0, 0, -1, 0, -1, 1, 0, 0, 1, 0, 0, -1, 0, 1, -1, 0, 0, 1, 0, 1, 1, 0),
    uvs: Float32Array.of(0, 1, 0.5, 1, 0, 0, 0.5, 0, 0.5, 1, 1, 1, 0.5, 0, 1, 0),
    indices: Uint16Array.of(0, 1, 2, 3, 3, 4, 4, 5, 6, 7),
  });
  const quarterTurn = { texCoord: 1, offset: [0, 1], rotation: Math.PI / 2 };
  const turnedTexture = { index: 0, extensions: { KHR_texture_transform: quarterTurn } };
  const document = {
    extensionsUsed: ['KHR_texture_transform'], scene: 0, scenes: [{ nodes: [0, 1, 2, 4, 5] }],
    nodes: [
      { mesh: 0, translation: [-2, 1, 0] },
      { mesh: 1, translation: [2, 1, 0], rotation: [0, 0, 1, 0] },
      { children: [3], translation: [-2, 0, 0] },
      { mesh: 1, matrix: [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1] },
      { mesh: 2, translation: [0, -1, 0] },
      { mesh: 3, translation: [2, -1, 0] },
    ],
    meshes: [
      { primitives: two }, { primitives: [{ ...glb.square(), material: 0 }] },
      { primitives: [{ ...turned, material: 2 }] }, { primitives: [{ ...strip, mode: 5, material: 0 }] },
    ],
    materials: [
      TEXTURED, { pbrMetallicRoughness: { baseColorTexture: { index: 1 } } },
      { pbrMetallicRoughness: { baseColorTexture: turnedTexture } },
    ],
    textures: [{ source: glb.image(picture) }, { source: glb.image({ uri: `data:image/png;base64,${other.toString('base64')}` }) }],
  };

  await dropFiles(page, [['board.glb', glb.file(document)]]);
  await createScene(page);
  await lookAtColours();
  await shot('viewer_glb');

  const rows = [1, -1].map((y) => [-2, 0, 2].map((x) => [x, y] as const)).flat();
  const seen: string[] = [];
  for (const [x, y] of rows) seen.push(await quarters(x, y));
  assert.deepEqual(seen, [
    'red green blue white', 'white blue green red', 'white blue green red', // as it is, the other picture, half a turn
    'green red white blue', 'blue red white green', 'red green blue white', // mirrored, a quarter turn clockwise, a strip
  ]);
  assert.deepEqual([await nameAt(1.9, -0.1), await nameAt(2.9, -0.1)], ['red', 'green']); // where the strip's triangles turn
});

test('a GLB says which of its colours are not shown, and takes a picture that is dropped for the one it names', async () => {
  const glb = new GlbMaker();
  const square = glb.square({ uvs: SQUARE.uvs.map((x) => 2 * x) });
  square.attributes.COLOR_0 = glb.accessor(new Float32Array(12).fill(1), 'VEC3');
  const textures = [{ source: glb.image({ uri: 'art/Squares%20one.png' }), sampler: 0 }];
  const content = glb.file({
    ...ONE_NODE, meshes: [{ primitives: [{ ...square, material: 0 }] }], materials: [TEXTURED], textures,
    samplers: [{ wrapS: 33071, wrapT: 10497 }], extensionsUsed: ['KHR_materials_pbrSpecularGlossiness'],
  });
  const asked: string[] = [];
  page.on('request', (request) => /squares/i.test(request.url()) && asked.push(request.url()));

  await dropFiles(page, [['named.glb', content]]);
  await createScene(page);
  await page.getByText('named.glb names the picture art/Squares one.png, which was not dropped with it.').waitFor();
  await page.getByText('The colours of vertices that named.glb has are not shown.').waitFor();
  await page.getByText('Materials of named.glb are of KHR_materials_pbrSpecularGlossiness, whose pictures are not shown.').waitFor();
  errors.length = 0; // three says it in the console too
  await dropFiles(page, [['squares one.png', picture]]);
  await page.getByText('named.glb clamps or mirrors pictures outside of 0 to 1; they are shown repeated.').waitFor();
  await lookAtColours();

  const corner = await Promise.all([[-0.75, 0.75], [-0.25, 0.75], [-0.75, 0.25], [-0.25, 0.25]].map(([x, y]) => nameAt(x, y)));
  assert.deepEqual(corner, ['red', 'green', 'blue', 'white']);
  assert.deepEqual(asked, []);
});

/** Waits until this browser keeps so many files beside the mesh that is open. */
async function keptBeside(of: Page, files: number): Promise<void> {
  await of.waitForFunction(async (count) => {
    const { services, opener } = window.latticed;
    const { companions } = await services.keptMesh((opener as unknown as { mesh: { id: string } }).mesh.id);
    return companions.length === count;
  }, files);
}

/** Waits until this browser keeps what a server that has lost the scene needs of it. */
async function keptScene(of: Page): Promise<void> {
  await of.waitForFunction(() => new Promise((resolve) => {
    const { opener, scene } = window.latticed;
    const request = indexedDB.open('latticed');
    request.onsuccess = () => {
      const transaction = request.result.transaction(['meshes', 'scenes']);
      const mesh = transaction.objectStore('meshes').getKey((opener as unknown as { mesh: { id: string } }).mesh.id);
      const kept = transaction.objectStore('scenes').getKey(scene!.session.sceneId);
      request.result.close(); // when all is answered
      transaction.oncomplete = () => resolve(mesh.result !== undefined && kept.result !== undefined);
    };
  }));
}

test('pictures dropped beside an OBJ are shown after a reload, a restart of the server, and in this browser\'s other windows', async () => {
  const mtl = 'newmtl all\nmap_Kd squares.png\n';
  await dropFiles(page, [['sheet.mtl', mtl], ['squares.png', other], ['sheet.obj', sheetObj((quad) => (quad === 0 ? 'usemtl all' : ''))]]);
  await createScene(page);
  await lookAtColours();
  await dropFiles(page, [['squares.png', picture]]); // in place of the one before
  await keptBeside(page, 2);

  await page.reload();
  await live(page);
  await lookAtColours();
  assert.equal(await quarters(), 'red green blue white');
  const [second] = await Promise.all([page.waitForEvent('popup'), page.evaluate(() => void window.open(location.href))]);
  await live(second);
  await lookAtColours(second);
  assert.equal(await quarters(0, 0, second), 'red green blue white');
  await second.close();

  await keptScene(page);
  const address = page.url();
  await page.goto('about:blank');
  await server.kill();
  await server.restart();
  await page.goto(address);
  await page.getByText('this browser restored mesh and lattice').waitFor();
  await lookAtColours();
  assert.equal(await quarters(), 'red green blue white');
  errors.length = 0; // of calls for the scene that was lost
});

test('another browser shows a mesh without what was dropped beside it, and says so where its texture is chosen', async () => {
  const { page: elsewhere } = await openPage(browser, page.url());
  await live(elsewhere);
  const colouring = (): Promise<string> => elsewhere.evaluate(() => window.latticed.settings.value.colouring);
  assert.equal(await colouring(), 'plain');

  await elsewhere.keyboard.press('n'); // the panel
  await elsewhere.getByLabel('Colour', { exact: true }).selectOption('texture');
  await elsewhere.getByText('This browser has no pictures for sheet.obj, and shows a grid. Those dropped in another stay there.').waitFor();
  await lookAtColours(elsewhere); // the grid
  await dropFiles(elsewhere, [['squares.png', other]]);
  await keptBeside(elsewhere, 1);
  await elsewhere.reload();
  await live(elsewhere);
  await lookAtColours(elsewhere);

  assert.equal(await quarters(0, 0, elsewhere), 'white blue green red');
  await elsewhere.close();
});

test('a GLB is shown with its own pictures after a reload, in other windows and in other browsers', async () => {
  await dropFiles(page, [['sheet.glb', squareGlb()]]);
  await createScene(page);

  await page.reload();
  await live(page);
  await lookAtColours();
  assert.equal(await quarters(), 'red green blue white');
  const { page: elsewhere } = await openPage(browser, page.url());
  await live(elsewhere);
  await lookAtColours(elsewhere);
  assert.equal(await quarters(0, 0, elsewhere), 'red green blue white');
  await elsewhere.close();
});

test('pictures that the browser has no room for are shown, and it is said that they are not kept', async () => {
  const { page: full } = await openPage(browser, server.origin);
  await limitStorage(full, 1e5);

  await dropFiles(full, [['sheet.obj', sheetObj()], ['squares.png', picture], ['sheet.mtl', '#'.repeat(300_000)]]);
  await createScene(full);

  await full.locator('.toast-error').getByText(
    'After a reload this mesh will be without what was dropped beside it: the browser has no room left for it.').waitFor();
  await lookAtColours(full);
  assert.equal(await quarters(0, 0, full), 'red green blue white');
  await full.close();
});

test('a lattice of another frame leaves the mesh in its colours', async () => {
  const vector = (x: number, y: number, z: number): object => ({ x, y, z });
  const frame = { origin: vector(-1.5, -1.5, -1), u: vector(3, 0, 0), v: vector(0, 3, 0), w: vector(0, 0, 2) };
  const lattice = latticeFromJson(JSON.stringify({ frame, size: { u: 2, v: 2, w: 2 }, degree: { u: 1, v: 1, w: 1 } }));
  const before = page.url();

  await dropFiles(page, [['lattice.json', latticeToJson(lattice)]]);
  await page.waitForFunction((address) => location.href !== address, before);
  await live(page);
  await lookAtColours();

  assert.equal(await quarters(), 'red green blue white');
});

test('a GLB with bones and morph targets is shown at rest, and says so', async () => {
  const glb = new GlbMaker();
  const square = glb.square();
  const raised = glb.accessor(Float32Array.of(0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1), 'VEC3');
  const mesh = { primitives: [{ ...square, targets: [{ POSITION: raised }] }], weights: [0] };
  const nodes = [{ mesh: 0, skin: 0 }, {}];

  await dropFiles(page, [['fox.glb', glb.file({ ...ONE_NODE, nodes, skins: [{ joints: [1] }], meshes: [mesh] })]]);
  await createScene(page);

  await page.getByText('fox.glb is shown at rest, without its bones and morph targets.').waitFor();
  const { min, max } = await page.evaluate(() => window.latticed.scene!.session.surface.bounds);
  assert.ok(Math.abs(min.z) < 1e-3 && Math.abs(max.z) < 1e-3, `${min.z} to ${max.z}`);
});

test('a GLB with pictures or a mesh of a kind that is not read is refused in words', async () => {
  const pictures = new GlbMaker();
  const primitives = [{ ...pictures.square(), material: 0 }];
  const textures = [{ extensions: { KHR_texture_basisu: { source: pictures.image(picture) } } }];
  const required = (name: string): object => ({ extensionsUsed: [name], extensionsRequired: [name] });
  const ktx = pictures.file({ ...ONE_NODE, ...required('KHR_texture_basisu'), meshes: [{ primitives }], materials: [TEXTURED], textures });
  const packed = new GlbMaker();
  const meshes = [{ primitives: [packed.square()] }];

  await dropFiles(page, [['ktx.glb', ktx]]);
  await createScene(page);
  await page.locator('.toast-error').getByText(/^Pictures of ktx\.glb are of a kind that is not shown, KTX2 for instance/).waitFor();
  assert.equal(await page.evaluate(() => window.latticed.settings.value.colouring), 'plain');
  assert.deepEqual(errors, []);

  await dropFiles(page, [['broken.glb', squareGlb(Buffer.from('no picture'))]]);
  await createScene(page);
  await page.getByText('A picture of broken.glb cannot be read.').waitFor();

  await dropFiles(page, [['packed.glb', packed.file({ ...ONE_NODE, ...required('KHR_draco_mesh_compression'), meshes })]]);
  await page.locator('.fit .error').getByText(/extension .KHR_draco_mesh_compression. is not supported/).waitFor();
});

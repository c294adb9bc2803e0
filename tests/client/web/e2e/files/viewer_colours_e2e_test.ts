// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Colours and pictures of dropped meshes in the viewer in Chromium.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { lookAtColours, nameAt, ONE_NODE, paint, quarters, squareGlb, TEXTURED } from './colours';
import { GlbMaker, SQUARE } from '../support/glb';
import { plainSheetObj, sheetObj, sheetPly } from '../support/sheet';
import { errors, page, shot, useStage } from '../support/stage';
import { createScene, dropFiles } from '../support/viewer_page';

let picture: Buffer; // red green above blue white
let other: Buffer; // white blue above green red

useStage({
  begin: async () => {
    picture = await paint(page, 'red', 'lime', 'blue', 'white');
    other = await paint(page, 'white', 'blue', 'lime', 'red');
  },
});

/** Waits for an act, and meanwhile for messages of the page, which leave after some seconds. */
async function saying(messages: readonly string[], act: Promise<void>): Promise<void> {
  await Promise.all([act, ...messages.map((message) => page.getByText(message).waitFor())]);
}

const DROPS: Record<string, () => [string, string | Buffer][]> = {
  'an OBJ with a picture': () => [['readme.txt', 'Fine art.'], ['squares.png', picture], ['sheet.obj', sheetObj()]],
  'a PLY with the picture that it names': () => [['Squares.png', picture], ['other.png', Buffer.from('')], ['sheet.ply', sheetPly()]],
  'a GLB with a picture inside': () => [['sheet.glb', squareGlb(picture)]],
};
for (const [what, files] of Object.entries(DROPS)) {
  test(`${what} is shown with it, the right way up`, async () => {
    await dropFiles(page, files());
    await createScene(page);
    await lookAtColours(page);

    assert.equal(await quarters(page), 'red green blue white');
  });
}

test('an OBJ with its MTL file has a picture and a colour by material, and a lost picture is said', async () => {
  const mtl = 'newmtl wood\nKd 1 1 1\nmap_Kd textures/squares.png\nnewmtl paint\nKd 0 0 1\nnewmtl lost\nKd 1 0 0\nmap_Kd gone.png\n';
  const material = (quad: number): string => `usemtl ${quad % 4 < 2 ? 'wood' : quad < 8 ? 'paint' : 'lost'}`;

  await dropFiles(page, [['sheet.mtl', mtl], ['sheet.obj', sheetObj(material)], ['squares.png', picture]]);
  await saying(['sheet.obj names the picture gone.png, which was not dropped with it.'], createScene(page));
  await lookAtColours(page);

  assert.equal(await quarters(page), 'red red blue blue');
  await shot('viewer_materials');
});

test('a mesh that has no texture coordinates says so, and is shown plain', async () => {
  await dropFiles(page, [['plain.obj', plainSheetObj()], ['squares.png', picture]]);
  await saying(['plain.obj has no texture coordinates.'], createScene(page));

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
  // The left and right halves, joined by triangles without area.
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
  await lookAtColours(page);
  await shot('viewer_glb');

  const rows = [1, -1].map((y) => [-2, 0, 2].map((x) => [x, y] as const)).flat();
  const seen: string[] = [];
  for (const [x, y] of rows) seen.push(await quarters(page, x, y));
  assert.deepEqual(seen, [
    'red green blue white', 'white blue green red', 'white blue green red', // as it is, the other picture, half a turn
    'green red white blue', 'blue red white green', 'red green blue white', // mirrored, a quarter turn clockwise, a strip
  ]);
  // These points are in triangles of the strip whose winding is reversed.
  assert.deepEqual([await nameAt(page, 1.9, -0.1), await nameAt(page, 2.9, -0.1)], ['red', 'green']);
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
  await saying([
    'named.glb names the picture art/Squares one.png, which was not dropped with it.',
    'The vertex colours of named.glb are not shown.',
    'Materials of named.glb are of KHR_materials_pbrSpecularGlossiness, whose pictures are not shown.',
  ], createScene(page));
  errors.length = 0; // three.js reports it in the console too
  await dropFiles(page, [['squares one.png', picture]]);
  await page.getByText('named.glb clamps or mirrors pictures outside of 0 to 1; they are shown repeated.').waitFor();
  await lookAtColours(page);

  const corner = await Promise.all([[-0.75, 0.75], [-0.25, 0.75], [-0.75, 0.25], [-0.25, 0.25]].map(([x, y]) => nameAt(page, x, y)));
  assert.deepEqual(corner, ['red', 'green', 'blue', 'white']);
  assert.deepEqual(asked, []);
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
  await saying(['A picture of broken.glb cannot be read.'], createScene(page));

  await dropFiles(page, [['packed.glb', packed.file({ ...ONE_NODE, ...required('KHR_draco_mesh_compression'), meshes })]]);
  await page.locator('.fit .error').getByText(/extension .KHR_draco_mesh_compression. is not supported/).waitFor();
});

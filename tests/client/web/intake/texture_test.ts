// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { File as NodeFile, resolveObjectURL } from 'node:buffer';
import { test } from 'node:test';
import { shownAtRest } from '@src/intake/glb_json';
import { GlbPictures } from '@src/intake/glb_pictures';
import type { MeshFile, MeshFormatName } from '@src/intake/mesh_file';
import { hasColours, meshLayers } from '@src/intake/mesh_layers';
import { readMtl } from '@src/intake/mtl';
import { objCorners } from '@src/intake/obj_uvs';
import { plyCorners } from '@src/intake/ply_uvs';
import { GlbMaker } from '../e2e/support/glb';

const GRID = {} as ImageBitmapSource; // stands in for a picture

function mesh(name: string, content: string | Uint8Array<ArrayBuffer>): MeshFile {
  return { name, format: name.slice(name.lastIndexOf('.') + 1) as MeshFormatName, content: new Blob([content]) };
}

function file(name: string, text: string): File {
  return new NodeFile([text], name) as unknown as File;
}

function picture(name: string): File {
  return file(name, 'not looked into');
}

test('corners of an OBJ come in the order of faces, with the number of their material, 0 0 where there is no coordinate', () => {
  const text =
    'v 0 0 0\nvt 0 0.25\nvt 0.5 1\nf 1/2 2/1/7 \\\n 3\nvt 1 1\nusemtl red wood\nf 1/-1 2/-3 3/2 \r\nusemtl x\nf 1 2 3';

  const { corners, materials, hasUvs } = objCorners(text);

  assert.deepEqual([...corners.subarray(0, 18)], [0.5, 1, 0, 0, 0.25, 0, 0, 0, 0, 1, 1, 1, 0, 0.25, 1, 0.5, 1, 1]);
  assert.deepEqual([...corners.subarray(18)], [0, 0, 2, 0, 0, 2, 0, 0, 2]);
  assert.deepEqual(materials, ['', 'red wood', 'x']);
  assert.equal(hasUvs, true);
  assert.equal(objCorners('v 0 0 0\nf 1 1 1').hasUvs, false);
});

test('an MTL file names colours and pictures, after options, with blanks in names', () => {
  const materials = readMtl(
    '# c\nnewmtl red wood\nKd 1 0 0.5\nmap_Kd -s 2 2 -clamp on -o 0.5 tex\\my wood.png\r\nnewmtl plain\nKd 0 1 0\n' +
      'newmtl grey\nKd 0.5\nnewmtl measured\nKd spectral file.rfl 1\n',
  );

  assert.deepEqual(materials.get('red wood'), { colour: 'rgb(255 0 128)', picture: 'tex\\my wood.png' });
  assert.deepEqual(materials.get('plain'), { colour: 'rgb(0 255 0)' });
  assert.equal(materials.get('grey')?.colour, 'rgb(128 128 128)');
  assert.equal(materials.get('measured')?.colour, undefined);
});

const PLY_VERTICES = 'element vertex 3\nproperty float x\nproperty float y\nproperty float z\n';
const PLY_FACES = 'element face 1\nproperty list uchar int vertex_indices\n';

test('a PLY has coordinates at its vertices', () => {
  const uvs = 'property uchar red\nproperty float s\nproperty float t\n';
  const text = `ply\nformat ascii 1.0\ncomment TextureFile wood.png\n${PLY_VERTICES}${uvs}${PLY_FACES}end_header\n`;

  const read = plyCorners(new TextEncoder().encode(`${text}0 0 0 9 0 .25\n1 0 0 9 1 .5\n0 1 0 9 .5 1\n3 2 0 1\n`));

  assert.deepEqual(read, { corners: Float32Array.of(0.5, 1, 0, 0, 0.25, 0, 1, 0.5, 0), pictures: ['wood.png'] });
});

for (const little of [true, false]) {
  test(`a binary PLY, ${little ? 'little' : 'big'} endian, has coordinates at the corners of its faces`, () => {
    const wedge = 'property list uchar float texcoord\nproperty int texnumber\n';
    const header =
      `ply\r\nformat binary_${little ? 'little' : 'big'}_endian 1.0\r\ncomment TextureFile a.png\r\ncomment TextureFile b c.png\r\n` +
      `${PLY_VERTICES}element edge 1\nproperty ushort n\n${PLY_FACES}${wedge}end_header\r\n`;
    const body = new DataView(new ArrayBuffer(36 + 2 + 1 + 12 + 1 + 24 + 4));
    [0, 0, 0, 1, 0, 0, 0, 1, 0].forEach((x, i) => body.setFloat32(4 * i, x, little));
    body.setUint8(38, 3);
    [2, 0, 1].forEach((index, i) => body.setInt32(39 + 4 * i, index, little));
    body.setUint8(51, 6);
    [0, 0.5, 1, 0.25, 0.75, 1].forEach((x, i) => body.setFloat32(52 + 4 * i, x, little));
    body.setInt32(76, 1, little);
    const bytes = new Uint8Array([...new TextEncoder().encode(header), ...new Uint8Array(body.buffer)]);

    assert.deepEqual(plyCorners(bytes), {
      corners: Float32Array.of(0, 0.5, 1, 1, 0.25, 1, 0.75, 1, 1),
      pictures: ['a.png', 'b c.png'],
    });
  });
}

test('without an MTL file a picture is for the material of its name, and a single one for all', async () => {
  const obj = mesh('t.obj', 'vt 0 0\nusemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 1/1 2/1 3/1\n');
  const [a, b] = [picture('a.png'), picture('b.png')];

  assert.deepEqual((await meshLayers(obj, [b, a], GRID)).layers, [{ picture: a }, { picture: b }]);
  assert.deepEqual((await meshLayers(obj, [b], GRID)).layers, [{ picture: b }, { picture: b }]);
  assert.deepEqual((await meshLayers(obj, [], GRID)).layers, [{ picture: GRID }, { picture: GRID }]);
});

test('one picture will do for a PLY that names another, or none', async () => {
  const wood = picture('wood.png');
  for (const comments of ['comment TextureFile gone.png\n', '']) {
    const ply = mesh('one.ply',
      `ply\nformat ascii 1.0\n${comments}${PLY_VERTICES}property float u\nproperty float v\n${PLY_FACES}end_header\n` +
      '0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n');
    assert.deepEqual((await meshLayers(ply, [wood], GRID)).layers, [{ picture: wood }]);
  }
});

test('what cannot be textured is refused in words, and what has no colours does not ask for them', async () => {
  const bare = mesh('bare.ply', `ply\nformat ascii 1.0\n${PLY_VERTICES}${PLY_FACES}end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n`);
  const strips = mesh('s.ply', 'ply\nformat ascii 1.0\nelement tristrips 0\nproperty list uchar int vertex_indices\nend_header\n');
  const stl = mesh('a.stl', 'solid');

  await assert.rejects(meshLayers(bare, [picture('a.png')], GRID), /bare.ply has no texture coordinates/);
  await assert.rejects(meshLayers(strips, [], GRID), /triangle strips/);
  await assert.rejects(meshLayers(stl, [], GRID), /STL/);
  await assert.rejects(meshLayers(mesh('a.drc', ''), [], GRID), /Draco/);
  await assert.rejects(meshLayers(mesh('a.obj', 'f 1 2 3'), [], GRID), /a.obj has no texture coordinates/);
  assert.equal(await hasColours(stl, [picture('a.png')]), true);
  assert.equal(await hasColours(bare, []), false);
  assert.equal(await hasColours(bare, [picture('a.png')]), true);
});

test('a picture inside an address of a GLB is read whatever parameters the address has, escaped or not', async () => {
  const pictures = new GlbPictures([]);
  const read = async (address: string): Promise<[string, number[]]> => {
    const blob = resolveObjectURL(pictures.manager.resolveURL(address))!;
    return [blob.type, [...new Uint8Array(await blob.arrayBuffer())]];
  };

  for (const address of [
    'data:image/png;base64,iVD/', 'data:image/png;charset=utf-8;base64,iVD/', 'data:image/png;name="a b";q=1;base64,iVD/',
    'DATA:image/PNG;BASE64,iVD%2F', 'data:image/png; base64,iVD/', 'data:image/png,%89P%ff', 'data:image/png;charset=latin1,%89P%FF',
  ]) {
    assert.deepEqual(await read(address), ['image/png', [0x89, 0x50, 0xff]], address);
  }
  assert.deepEqual([pictures.broken, pictures.missing], [false, []]);
  pictures.dispose();
});

test('an address of a GLB that holds no picture is a broken one', () => {
  for (const address of ['data:image/png;base64,iVD*', 'data:image/png;base64', 'data:image/png;charset=utf-8;base64,i']) {
    const pictures = new GlbPictures([]);
    assert.equal(pictures.manager.resolveURL(address), 'blob:nowhere');
    assert.deepEqual([pictures.broken, pictures.missing], [true, []], address);
  }
});

const TARGETS = [{ POSITION: 1 }];
const POSED = { nodes: [{ mesh: 0 }, { mesh: 0, skin: 0 }], meshes: [{ primitives: [{ attributes: {} }, { attributes: {}, targets: TARGETS }] }] };
for (const [document, what] of [
  [{ nodes: POSED.nodes }, 'bones'],
  [{ meshes: POSED.meshes }, 'morph targets'],
  [{ ...POSED, animations: [{}] }, 'bones, morph targets and animations'],
  [{ nodes: null, meshes: [{}, { primitives: null }, { primitives: [{ targets: null }, { targets: TARGETS }] }] }, 'morph targets'],
  [{ nodes: [{ mesh: 0 }], meshes: [{ primitives: [{ targets: [] }] }], skins: [{}], animations: [] }, undefined],
  [{ nodes: [{ mesh: 0, skin: null }], meshes: null, animations: null }, undefined],
] as const) {
  test(`a GLB of ${JSON.stringify(document)} is ${what ? `said to be shown at rest, without its ${what}` : 'shown as it is'}`, async () => {
    const glb = mesh('fox.glb', new GlbMaker().file(document) as Uint8Array<ArrayBuffer>);
    assert.equal(await shownAtRest(glb), what && `fox.glb is shown at rest, without its ${what}.`);
  });
}

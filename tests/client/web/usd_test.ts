// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// USD files of latticectl, read by three.js: positions, texture coordinates and groups are those of the OBJ file.
// Environment: LATTICECTL, the program.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Mesh, Vector3, type Object3D } from 'three';
import { USDLoader } from 'three/examples/jsm/loaders/USDLoader.js';

let folder: string;

function latticectl(...words: readonly string[]): void {
  execFileSync(process.env.LATTICECTL!, words, { cwd: folder, stdio: ['ignore', 'ignore', 'inherit'] });
}
const text = (name: string): string => readFileSync(join(folder, name), 'utf8');

before(() => {
  folder = mkdtempSync(join(tmpdir(), 'latticed-usd-'));
  for (const name of ['gear', 'beam']) {
    latticectl('sample', name, '--resolution', '2', '-o', `${name}.obj`);
    latticectl('lattice', `${name}.obj`, '--twist', '40', '--bend', '60', '-o', `${name}.json`);
  }
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** A corner's position and texture coordinate, by 4 digits, as text that can be sorted. */
const corner = (...numbers: number[]): string => numbers.map((x) => (Math.round(x * 1e4) / 1e4 + 0).toFixed(4)).join(' ');

function cornersOfObj(obj: string): string[] {
  const lines = obj.split('\n').map((line) => line.split(' '));
  const numbers = (kind: string): number[][] => lines.filter(([word]) => word === kind).map(([, ...rest]) => rest.map(Number));
  const [positions, uvs] = [numbers('v'), numbers('vt')];
  return lines.filter(([word]) => word === 'f').flatMap(([, ...face]) => face.map((c) => {
    const [v, vt] = c.split('/').map(Number);
    return corner(...positions[v - 1], ...(uvs[vt - 1] ?? []));
  }));
}

function meshesOf(root: Object3D): Mesh[] {
  const meshes: Mesh[] = [];
  root.updateMatrixWorld(true);
  root.traverse((object) => {
    if (object instanceof Mesh) meshes.push(object as Mesh);
  });
  return meshes;
}

function cornersOf(mesh: Mesh): string[] {
  const { index } = mesh.geometry;
  const position = mesh.geometry.getAttribute('position');
  const uv = mesh.geometry.hasAttribute('uv') ? mesh.geometry.getAttribute('uv') : undefined;
  const count = index?.count ?? position.count;
  const at = new Vector3();
  return Array.from({ length: count }, (_, i) => {
    const v = index?.getX(i) ?? i;
    at.fromBufferAttribute(position, v).applyMatrix4(mesh.matrixWorld);
    return corner(at.x, at.y, at.z, ...(uv ? [uv.getX(v), uv.getY(v)] : []));
  });
}

/** The exact surface, as three.js reads it, and the text of the OBJ file. */
function exact(name: string): { mesh: Mesh; obj: string; usd: string } {
  for (const file of ['exact.obj', 'exact.usda']) {
    latticectl('apply', `${name}.obj`, '--lattice', `${name}.json`, '--segments', '2', '-o', file);
  }
  const [mesh] = meshesOf(new USDLoader().parse(text('exact.usda')));
  return { mesh, obj: text('exact.obj'), usd: text('exact.usda') };
}

test('the exact surface in USD has the corners and texture coordinates of the OBJ file', () => {
  const { mesh, obj } = exact('beam');
  assert.match(obj, /^vt /m);
  assert.deepEqual(cornersOf(mesh).sort(), cornersOfObj(obj).sort());
});

test('each group is a part of the mesh with a material of its name', () => {
  const { mesh, obj, usd } = exact('gear');
  assert.deepEqual(cornersOf(mesh).sort(), cornersOfObj(obj).sort());
  const groups = new Set(obj.match(/^usemtl .*/gm)?.map((line) => line.slice('usemtl '.length)));
  assert.deepEqual(groups, new Set(['bore', 'caps', 'teeth']));
  assert.equal(mesh.geometry.groups.length, groups.size);
  assert.deepEqual(new Set(usd.match(/def Material "[^"]*/g)?.map((line) => line.slice('def Material "'.length))), groups);
});

test('polygons stay polygons, and the axis that is up is said', () => {
  for (const file of ['moved.obj', 'moved.usda']) {
    latticectl('apply', 'gear.obj', '--lattice', 'gear.json', '--vertices-only', '--up', 'z', '-o', file);
  }
  const usd = text('moved.usda');
  const counts = /faceVertexCounts = \[([^\]]*)\]/.exec(usd)![1].split(', ').map(Number);
  const faces = text('moved.obj').match(/^f .*/gm)!.map((line) => line.split(' ').length - 1);
  assert.deepEqual(counts, faces);
  assert.ok(counts.some((n) => n > 3));
  assert.match(usd, /upAxis = "Z"/);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { File } from 'node:buffer';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { PerspectiveCamera } from 'three';
import type { Editor } from '@src/edit/editor';
import { fileKind, readMeshFile } from '@src/intake/mesh_file';
import { SAMPLES } from '@src/intake/samples';
import { WORLD_BASIS } from '@src/lattice/vec';
import type { LatticeEdit } from '@src/session/edits/lattice_edit';
import type { GestureListener } from '@src/session/scene_session';
import { chordOf } from '@src/ui/commands';
import { PullDrag } from '@src/viewport/drags';
import { nearestPoint, pointsInBox, projectAll } from '@src/viewport/projection';
import type { Viewport } from '@src/viewport/viewport';

const size = { width: 800, height: 600 };

/** Looks from z = 10 at the origin, y up. Its field of view is 90 degrees high: 20 units at the origin. */
function camera(): PerspectiveCamera {
  const made = new PerspectiveCamera(90, size.width / size.height, 1, 100);
  made.position.set(0, 0, 10);
  made.updateMatrixWorld();
  return made;
}

test('the nearest point in reach is picked, of two that overlap the front one', () => {
  const projected = projectAll(camera(), size, [0, 0, 0, 0, 0, -5, 1, 0, 0, 0, 0, 20]);
  const all = (): boolean => true;

  assert.equal(nearestPoint(projected, 403, 300, 10, all), 0);
  assert.equal(nearestPoint(projected, 403, 300, 10, (i) => i !== 0), 1);
  assert.equal(nearestPoint(projected, 428, 300, 10, all), 2);
  assert.equal(nearestPoint(projected, 415, 300, 10, all), undefined);
});

test('a box takes the points inside, whichever corner it was begun at', () => {
  const projected = projectAll(camera(), size, [0, 0, 0, 1, 1, 0, 3, 0, 0, 0, 0, 20]);

  assert.deepEqual(pointsInBox(projected, [440, 310], [390, 260], () => true), [0, 1]);
});

test('chords name letters by their key, digits of both pads, and other signs by themselves', () => {
  const press = (key: string, code: string, more: object = {}) =>
    chordOf({ key, code, ctrlKey: false, metaKey: false, altKey: false, shiftKey: false, ...more });

  assert.equal(press('z', 'KeyZ', { ctrlKey: true }), 'Ctrl+Z');
  assert.equal(press('Z', 'KeyZ', { metaKey: true, shiftKey: true }), 'Ctrl+Shift+Z');
  assert.equal(press('å', 'KeyA', { altKey: true }), 'Alt+A');
  assert.equal(press('z', 'KeyY', { ctrlKey: true }), 'Ctrl+Z'); // a German keyboard
  assert.equal(press('я', 'KeyZ', { ctrlKey: true }), 'Ctrl+Z'); // a Russian keyboard
  assert.equal(press('.', 'KeyE'), '.'); // a Dvorak keyboard
  assert.equal(press('1', 'Numpad1'), '1');
  assert.equal(press('?', 'Slash', { shiftKey: true }), '?');
  assert.equal(press('Escape', 'Escape'), 'Escape');
});

test('files are told apart by their names, and those that cannot be taken are refused in words', async () => {
  const read = (file: File, most = 0) => readMeshFile(file as unknown as globalThis.File, () => Promise.resolve(most));
  assert.equal(fileKind('Teapot.v2.OBJ'), 'mesh');
  assert.equal(fileKind('lattice.json'), 'lattice');
  assert.equal(fileKind('README'), undefined);
  await assert.rejects(read(new File(['x'], 'part.step')), /^Error: part.step is no mesh that the server reads/);
  await assert.rejects(read(new File([], 'part.stl')), /part.stl is empty/);
  const large = new File([new Uint8Array(2500)], 'part.ply');
  assert.equal((await read(large, 2500)).content.size, 2500);
  await assert.rejects(read(large, 2000), /part.ply is too large for the server: it has 2.50 kB, and the limit is 2.00 kB\./);
  const unreadable = { arrayBuffer: () => Promise.reject(new Error('NotFoundError')) } as Blob;
  const folder = Object.assign(new File(['x'], 'part.obj'), { slice: () => unreadable });
  await assert.rejects(read(folder), /The browser cannot read part.obj, 1 bytes\./);
});

for (const [name, { note }] of Object.entries(SAMPLES)) {
  test(`the sample ${name} has as many faces as the page says`, () => {
    const lines = readFileSync(`samples/${name}.obj`, 'utf8').split('\n');
    const faces = lines.filter((line) => line.startsWith('f ')).length;
    assert.ok(note.startsWith(`${faces.toLocaleString('en')} `), `${faces} ${note}`);
  });
}

/** A pull from (400, 300) in a front view at 30 pixels per unit. `picked` answers its pick. */
function pullOf(picked: () => Promise<unknown>) {
  const log: (LatticeEdit | string)[] = [];
  const misses: unknown[] = [];
  const shown: unknown[] = [];
  const listeners: GestureListener[] = [];
  const viewport = {
    ray: () => ({ origin: [0, 0, 10], direction: [0, 0, -1] }),
    transformView: () => ({ basis: WORLD_BASIS, jacobian: [[30, 0, 0], [0, -30, 0]] }),
  } as unknown as Viewport;
  const gesture = (listener: GestureListener) => {
    listeners.push(listener);
    return { update: (e: LatticeEdit) => log.push(e), commit: () => log.push('commit'), cancel: () => log.push('cancel') };
  };
  const editor = { session: { pick: picked, gesture } } as unknown as Editor;
  const drag = new PullDrag(viewport, editor, [400, 300], {
    missed: (error) => misses.push(error), pulled: (pull) => shown.push(pull) });
  return { log, misses, shown, listeners, drag };
}

const HELD = { face: 7, corners: [21, 22, 23], barycentrics: [0.2, 0.3, 0.5], position: [1, 2, 3] } as const;

test('a pull that was let go before its pick was answered is said not to be made; one that was taken back needs no word', async () => {
  for (const [letGo, wanted] of [['end', /before the server found the pressed point/], ['cancel', /^$/]] as const) {
    const { log, misses, drag } = pullOf(() => Promise.resolve(HELD));
    drag.move(430, 285);
    drag[letGo]();
    await new Promise((resolve) => setTimeout(resolve));

    assert.deepEqual(log, []);
    assert.match(misses.map(String).join(), wanted);
  }
});

test('a pull that the session has ended is over: its line goes, and what is left of the press does nothing', async () => {
  const { log, shown, listeners, drag } = pullOf(() => Promise.resolve(HELD));
  drag.move(430, 300);
  await new Promise((resolve) => setTimeout(resolve));
  assert.ok(shown.at(-1));

  listeners[0].ended!();
  drag.move(460, 300);
  drag.end();

  assert.equal(log.length, 1);
  assert.equal(shown.at(-1), undefined);
});

test('a press without a move pulls nothing, one beside the surface or unanswered is told', async () => {
  const still = pullOf(() => Promise.resolve(HELD));
  const beside = pullOf(() => Promise.resolve(undefined));
  const refused = pullOf(() => Promise.reject(new Error('gone')));

  await new Promise((resolve) => setTimeout(resolve));
  for (const { drag } of [still, beside, refused]) drag.end();

  assert.deepEqual([still.log, still.misses], [[], []]);
  assert.deepEqual(beside.misses, [undefined]);
  assert.match(String(refused.misses[0]), /gone/);
});

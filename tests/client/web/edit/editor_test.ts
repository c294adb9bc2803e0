// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Editor } from '@src/edit/editor';
import type { LatticeEdit } from '@src/session/edits/lattice_edit';
import { heldPoints, NO_CONSTRAINTS } from '@src/lattice/constraints';
import type { LiveSession } from '@src/session/live_session';
import { DEFAULT_SETTINGS, rememberedSettings } from '@src/state/settings';
import { Store } from '@src/state/store';
import { fitLattice } from '@src/lattice/fitted_lattice';

/** An editor whose session records its edits in `log`. */
function open(mayEdit = true, constraints = NO_CONSTRAINTS): { editor: Editor; log: (LatticeEdit | string)[] } {
  const log: (LatticeEdit | string)[] = [];
  const lattice = fitLattice({ min: [0, 0, 0], max: [2, 1, 1] }, { size: [4, 3, 3], degree: [2, 2, 2], padding: 0 });
  const session = {
    mayEdit,
    constraints,
    held: heldPoints(lattice.size, constraints),
    lattice,
    gesture: () => ({ update: (edit: LatticeEdit) => log.push(edit), commit: () => log.push('commit') }),
    announce: () => undefined,
  } as unknown as LiveSession;
  return { editor: new Editor(session, new Store(DEFAULT_SETTINGS), () => undefined), log };
}

test('rows and planes go through all selected points and keep the active one', () => {
  const { editor } = open();
  editor.selection.select([0, 5]);

  editor.selectRows(0, false);
  assert.deepEqual([...editor.selection.indices], [0, 1, 2, 3, 4, 5, 6, 7]);
  assert.equal(editor.selection.active, 5);

  editor.selection.select([5]);
  editor.selectRows(2, true);
  assert.equal(editor.selection.size, 12);
});

test('a typed position moves the pivot there', () => {
  const { editor, log } = open();
  editor.selection.select([0, 3]);

  editor.movePivotTo([1, 0, 2]);

  assert.deepEqual(log, [{ kind: 'move', indices: Uint32Array.of(0, 3), offset: [0, 0, 2] }, 'commit']);
});

test('where the token only allows to watch, nothing moves', () => {
  const { editor, log } = open(false);
  editor.selection.select([0, 3]);

  editor.movePivotTo([1, 0, 2]);

  assert.equal(editor.beginGesture(), undefined);
  assert.deepEqual(log, []);
});

test('held points stay, and a locked mirror takes images along', () => {
  const { editor, log } = open(true, { held: [1], layers: [], mirror: 0 });
  editor.selection.select([1, 2]);  // the one and its image
  assert.equal(editor.beginGesture(), undefined);

  editor.selection.select([0, 1]);
  editor.movePivotTo([1, 0, 2]);

  const [edit] = log;
  assert.ok(typeof edit === 'object' && edit.kind === 'set');
  assert.deepEqual([...edit.indices].sort(), [0, 3]);
});

test('a knot is offered in the middle of the widest interval', () => {
  const { editor } = open();

  assert.equal(editor.knotBetween(0), 0.5); // knots 0 0 0 1 2 2 2: the first of two equal intervals
  assert.equal(editor.knotBetween(1), 0.5); // knots 0 0 0 1 1 1
});

test('taste is remembered from visit to visit, what depends on the mesh is not, and broken storage is no error', () => {
  const kept = new Map<string, string>();
  const storage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
  };
  rememberedSettings(storage).set({ theme: 'light', orthographic: true });

  const { theme, orthographic } = rememberedSettings(storage).value;

  assert.deepEqual([theme, orthographic], ['light', false]);
  const refusing = {
    getItem: () => '{',
    setItem: () => {
      throw new Error('quota');
    },
  };
  const store = rememberedSettings(refusing);
  store.set({ theme: 'dark' });
  assert.equal(store.value.theme, 'dark');
});

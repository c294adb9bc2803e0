// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Editor } from '@src/edit/editor';
import { WORLD_BASIS, type Basis, type Vec3 } from '@src/lattice/vec';
import type { LatticeEdit } from '@src/session/edits/lattice_edit';
import type { LiveSession } from '@src/session/live_session';
import type { GestureListener } from '@src/session/scene_session';
import { DEFAULT_SETTINGS, rememberedSettings } from '@src/state/settings';
import { Store } from '@src/state/store';
import { fitLattice } from './support/fitted_lattice';

/** A session that writes down what it is asked. */
function recordingSession() {
  const log: (LatticeEdit | string)[] = [];
  const announced: number[][] = [];
  const listeners: GestureListener[] = [];
  const lattice = fitLattice({ min: [0, 0, 0], max: [2, 1, 1] }, { size: [4, 3, 3], degree: [2, 2, 2], padding: 0 });
  const session = {
    lattice,
    gesture: (listener: GestureListener) => {
      listeners.push(listener);
      return {
        update: (e: LatticeEdit) => log.push(e),
        commit: () => log.push('commit'),
        cancel: () => log.push('cancel'),
      };
    },
    announce: (selected: Uint32Array) => announced.push([...selected]),
  } as unknown as LiveSession;
  return { session, log, announced, listeners };
}

function open() {
  const recorded = recordingSession();
  const headlines: (string | undefined)[] = [];
  const editor = new Editor(recorded.session, new Store(DEFAULT_SETTINGS), (text) => headlines.push(text));
  const viewAt = (_pivot: Vec3, axes: Basis, secondAxes: Basis) => ({
    basis: WORLD_BASIS,
    jacobian: [[100, 0, 0], [0, -100, 0]] as const,
    pivot: [0, 0] as [number, number],
    axes,
    secondAxes,
    snapStep: 1,
  });
  const begin = (): boolean => editor.beginTransform('move', viewAt, WORLD_BASIS, [50, 50]);
  return { ...recorded, editor, headlines, begin };
}

test('G X 1 Enter on a selected point is one gesture: a move, then its commit', () => {
  const { editor, log, begin, headlines } = open();
  editor.selection.select([5]);

  assert.equal(begin(), true);
  for (const key of ['x', '1', 'Enter']) assert.equal(editor.keyPressed(key, false), true);

  assert.deepEqual(log, [{ kind: 'move', indices: Uint32Array.of(5), offset: [1, 0, 0] }, 'commit']);
  assert.equal(editor.transforming, false);
  assert.equal(headlines.at(-1), undefined);
});

test('Escape takes a gesture back; one that never moved anything is none', () => {
  const { editor, log, begin } = open();
  editor.selection.select([5]);

  begin();
  editor.keyPressed('Escape', false);
  assert.deepEqual(log, []);

  begin();
  editor.pointerMoved(60, 50, { shift: false, ctrl: false });
  editor.keyPressed('Escape', false);
  assert.equal(log.at(-1), 'cancel');
});

test('a transform whose gesture the session has ended is over: its line goes, and keys are no longer its own', () => {
  const { editor, log, begin, headlines, listeners } = open();
  editor.selection.select([5]);

  begin();
  editor.pointerMoved(60, 50, { shift: false, ctrl: false });
  listeners[0].ended!();
  assert.equal(editor.transforming, false);
  assert.equal(headlines.at(-1), undefined);
  editor.pointerMoved(70, 50, { shift: false, ctrl: false });
  for (const key of ['z', '2', 'Enter', 'Escape']) assert.equal(editor.keyPressed(key, false), false);
  editor.settings.set({ soft: { enabled: true, radius: 9, falloff: 'linear' } });

  assert.equal(log.length, 1);
  assert.equal(listeners.length, 1, 'and nothing begins anew');
});

test('a gesture of handles that the session has ended tells its owner and moves nothing more', () => {
  const { editor, log, listeners } = open();
  editor.selection.select([5]);
  let ended = 0;

  const gesture = editor.beginGesture(() => ++ended)!;
  gesture.update({ kind: 'move', offset: [1, 0, 0] });
  listeners[0].ended!();
  gesture.update({ kind: 'move', offset: [2, 0, 0] });
  gesture.cancel();

  assert.equal(ended, 1);
  assert.equal(log.length, 1);
});

test('while a transform runs its keys change how far soft selection reaches, from where the points were', () => {
  const { editor, log, begin } = open();
  const moved = (): number => {
    const edit = log.at(-1)!;
    assert.ok(typeof edit === 'object');
    return edit.kind === 'set' ? edit.indices.length : 1;
  };
  editor.settings.set({ soft: { enabled: true, radius: 0.6, falloff: 'linear' } });
  editor.selection.select([0]); // its neighbours are 0.5 and more away

  begin();
  editor.keyPressed('x', false);
  editor.keyPressed('1', false);
  assert.equal(moved(), 4);
  for (let i = 0; i < 3; ++i) assert.equal(editor.keyPressed('PageUp', false), true);
  assert.ok(Math.abs(editor.settings.value.soft.radius - 0.6 * 1.1 ** 3) < 1e-12);
  assert.equal(moved(), 7);
  for (let i = 0; i < 6; ++i) editor.keyPressed('[', false);
  assert.equal(moved(), 1);
  editor.keyPressed(']', false);
  editor.keyPressed('o', false);
  assert.equal(moved(), 1);
  editor.keyPressed('Enter', false);

  editor.resizeSoft(5);
  assert.equal(log.at(-1), 'commit');
});

test('without a keyboard a number comes as a text, and fine and snap are held', () => {
  const { editor, log, begin } = open();
  editor.selection.select([5]);

  begin();
  editor.keyPressed('X', true);
  editor.typeAmount('-1.5');
  assert.deepEqual(log.at(-1), { kind: 'move', indices: Uint32Array.of(5), offset: [0, -1.5, 0] });
  editor.typeAmount('');
  editor.hold({ shift: false, ctrl: true });
  editor.pointerMoved(50, -90, { shift: false, ctrl: false }); // 1.4 up, by steps of 1

  assert.deepEqual(log.at(-1), { kind: 'move', indices: Uint32Array.of(5), offset: [0, 1, 0] });
});

test('without a selection no transform begins', () => {
  const { editor, begin, log } = open();

  assert.equal(begin(), false);
  assert.equal(editor.transforming, false);
  assert.deepEqual(log, []);
});

test('what is selected is announced to other windows', () => {
  const { editor, announced } = open();

  editor.selection.select([5, 3]);

  assert.deepEqual(announced, [[3, 5]]);
});

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

test('a knot is offered in the middle of the widest interval', () => {
  const { editor } = open();

  assert.equal(editor.knotBetween(0), 0.5); // 0 0 0 1 2 2 2: the first of two alike
  assert.equal(editor.knotBetween(1), 0.5); // 0 0 0 1 1 1
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

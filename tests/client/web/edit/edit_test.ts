// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { beginSpread, buildEdit } from '@src/edit/build_edit';
import { softWeights } from '@src/edit/falloff';
import { moved, motionMatrix, type Motion } from '@src/edit/motion';
import type { Pivot } from '@src/edit/pivot';
import { Selection } from '@src/edit/selection';
import { pointAt } from '@src/lattice/vec';
import { fitLattice } from '@src/lattice/fitted_lattice';

// Points 0 to 3 along u are at x = 0, 0.5, 1.5 and 2.
const lattice = fitLattice({ min: [0, 0, 0], max: [2, 1, 1] }, { size: [4, 3, 3], degree: [2, 2, 2], padding: 0 });
const off = {
  soft: { enabled: false, radius: 1, falloff: 'linear' },
  mirror: [false, false, false],
  pivot: 'median',
} as const;
const shown = (): boolean => false;

function close(got: ArrayLike<number>, wanted: ArrayLike<number>): void {
  assert.equal(got.length, wanted.length);
  Array.from(got).forEach((x, i) =>
    assert.ok(Math.abs(x - wanted[i]) < 1e-12, `${Array.from(got)} is not ${Array.from(wanted)}`),
  );
}

test('motions: a quarter turn, a scaling in a basis that is not orthogonal, and fractions of both', () => {
  const turn: Motion = { kind: 'rotate', axis: [0, 0, 1], angle: Math.PI / 2 };
  const stretch: Motion = {
    kind: 'scale',
    basis: [[1, 1, 0], [0, 1, 0], [0, 0, 1]],
    factors: [3, 1, 1],
  };

  close(moved(turn, [1, 0, 0], [2, 0, 5]), [1, 1, 5]);
  close(moved(turn, [1, 0, 0], [2, 0, 5], 0), [2, 0, 5]);
  close(moved(stretch, [0, 0, 0], [1, 1, 0]), [3, 3, 0]);
  close(moved(stretch, [0, 0, 0], [1, 1, 0], 0.5), [2, 2, 0]);
});

test('the matrix of a motion is column-major and does what the motion does', () => {
  const turn: Motion = { kind: 'rotate', axis: [0, 0, 1], angle: Math.PI / 2 };

  const m = motionMatrix(turn, [1, 0, 0]);

  close(m, [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 1, -1, 0, 1]);
});

test('a click replaces, Shift extends, Ctrl toggles; the last one is active', () => {
  const selection = new Selection(10);

  selection.select([3]);
  selection.select([5, 4], 'extend');
  selection.select([5, 9], 'toggle');

  assert.deepEqual([...selection.indices], [3, 4, 9]);
  assert.equal(selection.active, 9);
  selection.select([9], 'remove');
  assert.equal(selection.active, 4);
});

test('indices ascend as numbers, and hidden points are out of reach', () => {
  const selection = new Selection(12);

  selection.select([11, 2, 10]);
  assert.deepEqual([...selection.indices], [2, 10, 11]);
  selection.hide([10, 0]);
  selection.invert();

  assert.deepEqual([...selection.indices], [1, 3, 4, 5, 6, 7, 8, 9]);
  selection.reveal();
  selection.all();
  assert.equal(selection.size, 12);
});

test('soft selection falls from the nearest selected point to the radius', () => {
  const soft = { enabled: true, radius: 2, falloff: 'linear' } as const;

  const weights = softWeights(lattice.points, Uint32Array.of(0), soft, (i) => i > 3);

  assert.deepEqual(weights, [
    { index: 0, weight: 1, leader: 0 },
    { index: 1, weight: 0.75, leader: 0 },
    { index: 2, weight: 0.25, leader: 0 },
  ]);
});

test('the mirror reflects a move; a point in the middle stays in the middle', () => {
  const mirror = [true, true, false] as const;
  // Index 5 is the point (1, 1, 0): in the middle of the 3 points along v, but not of the 4 along u.
  const spread = beginSpread(lattice, Uint32Array.of(5), { ...off, mirror }, shown);

  const edit = buildEdit(spread, { kind: 'move', offset: [0.25, 0.5, 1] }, [0, 0, 0]);

  assert.ok(edit.kind === 'set');
  assert.deepEqual([...edit.indices], [5, 6]);
  close(edit.positions, [0.5 + 0.25, 0.5, 1, 1.5 - 0.25, 0.5, 1]);
});

test('each point about itself: a turn moves only what follows softly, about its leader', () => {
  const pivot: Pivot = 'each';
  const soft = { enabled: true, radius: 0.75, falloff: 'constant' } as const;
  const spread = beginSpread(lattice, Uint32Array.of(0), { ...off, pivot, soft }, (i) => i > 3);

  const edit = buildEdit(spread, { kind: 'rotate', axis: [0, 0, 1], angle: Math.PI / 2 }, [7, 7, 7]);

  assert.ok(edit.kind === 'set');
  assert.deepEqual([...edit.indices], [0, 1]);
  close(edit.positions, [0, 0, 0, 0, 0.5, 0]);
  close(pointAt(spread.start, 1), [0.5, 0, 0]);
});

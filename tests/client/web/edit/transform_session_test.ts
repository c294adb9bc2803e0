// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { transformHeadline } from '@src/edit/headline';
import type { Motion, MotionKind } from '@src/edit/motion';
import { TransformSession, snapStep, type TransformView } from '@src/edit/transform_session';
import { WORLD_BASIS } from '@src/lattice/vec';

// Looks along -z, x right and y up, 100 pixels per unit. The pointer begins 100 pixels to the right of the pivot.
const FRONT: TransformView = {
  basis: WORLD_BASIS,
  jacobian: [[100, 0, 0], [0, -100, 0]],
  pivot: [200, 100],
  axes: WORLD_BASIS,
  secondAxes: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
  snapStep: 0.5,
};
const FROM_BEHIND: TransformView = { ...FRONT, axes: [[1, 0, 0], [0, -1, 0], [0, 0, -1]] };
const QUARTER = Math.PI / 2;

/** Keys, or a pointer position and the modifier key held there. */
type Step = string | readonly [x: number, y: number, held?: 'Shift' | 'Ctrl'];

function after(kind: MotionKind, steps: readonly Step[], view = FRONT): TransformSession {
  const session = new TransformSession(kind, view, [300, 100]);
  for (const step of steps) {
    if (typeof step === 'string') {
      for (const key of step.split(' ')) assert.equal(session.key(key.replace('Shift+', ''), key.startsWith('Shift+')), 'running');
    } else {
      const [x, y, held] = step;
      session.pointer(x, y, { shift: held === 'Shift', ctrl: held === 'Ctrl' });
    }
  }
  return session;
}

/** The offset of a move, the factors of a scaling, or the axis of a turn times its angle. */
function numbersOf(motion: Motion): readonly number[] {
  if (motion.kind === 'move') return motion.offset;
  return motion.kind === 'scale' ? motion.factors : motion.axis.map((x) => x * motion.angle);
}

const TWO_TYPED = ['Shift+Y', '1 Tab 2'];
const THREE_TYPED = ['1 Tab - 2 . 5 Tab 3'];
const BALL_TYPED = ['r', '9 0 Tab - 9 0'];
for (const [what, kind, steps, wanted, view] of [
  ['follows the pointer in the plane of the view', 'move', [[350, 80]], [0.5, 0.2, 0]],
  ['keeps to the chosen axis by X', 'move', [[350, 80], 'x'], [0.5, 0, 0]],
  ["keeps to the lattice's axis by X X", 'move', [[350, 80], 'x x'], [0, 0.2, 0]],
  ['is free again by X X X', 'move', [[350, 80], 'x x x'], [0.5, 0.2, 0]],
  ['keeps by Shift to the plane across an axis, of which Y alone is not seen from its edge', 'move', [[350, 80], 'Shift+X'], [0, 0.2, 0]],
  ['takes a minus, a point and Backspace', 'move', ['y - 1 . 2 5 Backspace'], [0, -1.2, 0]],
  ['follows the pointer again when all of a number is deleted', 'move', [[400, 100], 'x 7 Backspace'], [1, 0, 0]],
  ['is fine from where Shift is pressed', 'move', [[400, 100], [500, 100, 'Shift']], [1.1, 0, 0]],
  ['snaps by Ctrl', 'move', [[400, 100], [500, 100, 'Shift'], [570, 100, 'Ctrl']], [2, 0, 0]],
  ['goes by Tab from number to number', 'move', THREE_TYPED, [1, -2.5, 3]],
  ['has the first number after the last, and the last before the first', 'move', [...THREE_TYPED, 'Tab 0 Shift+Tab 4'], [10, -2.5, 34]],
  ['has two numbers in a plane', 'move', TWO_TYPED, [1, 0, 2]],
  ['keeps the first number for an axis', 'move', [...TWO_TYPED, 'z'], [0, 0, 1]],
  ['has one number along an axis', 'move', [...TWO_TYPED, 'z', 'Tab 5'], [0, 0, 15]],
  ['follows the pointer about the line of sight', 'rotate', [[200, 0]], [0, 0, QUARTER]],
  ['takes degrees', 'rotate', [[200, 0], 'x 9 0'], [QUARTER, 0, 0]],
  ['turns with the pointer also about an axis that points away from the viewer', 'rotate', [[200, 0], 'z'], [0, 0, QUARTER], FROM_BEHIND],
  ['rolls a ball below the pointer by R R, a radian in a hundred pixels', 'rotate', ['r', [350, 130]], [0.3, 0.5, 0]],
  ['of a ball takes two numbers', 'rotate', BALL_TYPED, [QUARTER, -QUARTER, 0]],
  ['goes back from the ball by R', 'rotate', [...BALL_TYPED, 'r'], [0, 0, QUARTER]],
  ['goes back from the ball by an axis', 'rotate', [...BALL_TYPED, 'y'], [0, QUARTER, 0]],
  ['is the ratio of distances to the pivot, and leaves the normal of a plane', 'scale', [[400, 100], 'Shift+Z'], [2, 2, 1]],
  ['by one factor is of all axes', 'scale', ['. 5'], [0.5, 0.5, 0.5]],
  ['by two factors leaves the third at 1', 'scale', ['. 5 Tab 3'], [0.5, 3, 1]],
] as const satisfies readonly (readonly [string, MotionKind, readonly Step[], readonly number[], TransformView?])[]) {
  test(`${kind} ${what}`, () => {
    const got = numbersOf(after(kind, steps, view).motion());
    got.forEach((x, i) => assert.ok(Math.abs(x - wanted[i]) < 1e-9, `${got} is not ${wanted}`));
  });
}

for (const [kind, steps, orientation, wanted] of [
  ['move', ['1 Tab - 2 . 5'], 'world', 'Move  1  -2.5|  ·'],
  ['move', ['x 2'], 'world', 'Move  2|   along X (world)'],
  ['move', ['x 2 x'], 'view', 'Move  2|   along u (lattice)'],
  ['move', ['x 2 x'], 'lattice', 'Move  2|   along X (world)'],
  ['rotate', ['r', [350, 130]], 'world', 'Trackball  33.4°'],
] as const satisfies readonly (readonly [MotionKind, readonly Step[], string, string])[]) {
  test(`the headline of ${kind}, ${steps}, ${orientation} axes`, () =>
    assert.equal(transformHeadline(after(kind, steps), orientation), wanted));
}

test('an axis that points at the viewer does not run away', () => {
  const [, , z] = numbersOf(after('move', [[310, 100], 'z']).motion());
  assert.ok(Math.abs(z) <= 0.1, `${z}`);
});

test('a finger that comes down elsewhere moves nothing until it moves', () => {
  const session = after('move', []);

  session.resume(20, 20);
  assert.deepEqual(numbersOf(session.motion()).map(Math.abs), [0, 0, 0]);
  session.pointer(70, 20, { shift: false, ctrl: false });

  assert.deepEqual(numbersOf(session.motion()).map((x) => Number(x.toFixed(9))), [0.5, 0, 0]);
});

test('snap steps are 1, 2 or 5 times a power of ten', () => {
  assert.deepEqual([100, 24, 2].map((pixels) => snapStep(pixels)), [0.5, 1, 20]);
});

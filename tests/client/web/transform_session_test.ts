// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { transformHeadline } from '@src/edit/headline';
import type { MotionKind } from '@src/edit/motion';
import { TransformSession, snapStep, type TransformView } from '@src/edit/transform_session';
import { WORLD_BASIS, type Basis } from '@src/lattice/vec';

const NONE = { shift: false, ctrl: false };
// Looks along -z, x right and y up, 100 pixels a unit, the pivot at (200, 100).
const front: TransformView = {
  basis: WORLD_BASIS,
  jacobian: [[100, 0, 0], [0, -100, 0]],
  pivot: [200, 100],
  axes: WORLD_BASIS,
  secondAxes: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
  snapStep: 0.5,
};

function begin(kind: MotionKind, at: [number, number] = [300, 100], view = front): TransformSession {
  return new TransformSession(kind, view, at);
}

function type(session: TransformSession, keys: string): void {
  for (const key of keys) assert.equal(session.key(key, false), 'running');
}

function near(got: readonly number[], wanted: readonly number[]): void {
  got.forEach((x, i) => assert.ok(Math.abs(x - wanted[i]) < 1e-9, `${got} is not ${wanted}`));
}

function offset(session: TransformSession): readonly number[] {
  const motion = session.motion();
  assert.ok(motion.kind === 'move');
  return motion.offset;
}

test('G follows the pointer in the plane of the view', () => {
  const session = begin('move');

  session.pointer(350, 80, NONE);

  near(offset(session), [0.5, 0.2, 0]);
});

test('G X 1 Enter moves by one along X', () => {
  const session = begin('move');

  type(session, 'x1');

  near(offset(session), [1, 0, 0]);
  assert.equal(session.key('Enter', false), 'confirmed');
});

test("X once is the chosen axis, twice the lattice's, three times none", () => {
  const session = begin('move');
  session.pointer(350, 80, NONE);

  type(session, 'x');
  near(offset(session), [0.5, 0, 0]);
  type(session, 'x');
  near(offset(session), [0, 0.2, 0]);
  type(session, 'x');
  near(offset(session), [0.5, 0.2, 0]);
});

test('Shift with an axis keeps to the plane across it', () => {
  const session = begin('move');
  session.pointer(350, 80, NONE);

  assert.equal(session.key('X', true), 'running');

  // The plane of Y and Z is seen from its edge: only Y follows.
  near(offset(session), [0, 0.2, 0]);
});

test('the typed number takes a minus, a point and Backspace, and Escape cancels', () => {
  const session = begin('move');

  type(session, 'y-1.25');
  session.key('Backspace', false);

  near(offset(session), [0, -1.2, 0]);
  assert.equal(session.key('Escape', false), 'cancelled');
  assert.equal(session.key('F5', false), undefined);
});

test('Backspace over everything gives the pointer its word back', () => {
  const session = begin('move');
  session.pointer(400, 100, NONE);

  type(session, 'x7');
  session.key('Backspace', false);

  near(offset(session), [1, 0, 0]);
});

test('Shift is fine from where it is pressed, Ctrl snaps', () => {
  const session = begin('move');

  session.pointer(400, 100, NONE);
  session.pointer(500, 100, { shift: true, ctrl: false });
  near(offset(session), [1.1, 0, 0]);

  session.pointer(570, 100, { shift: false, ctrl: true });
  near(offset(session), [2, 0, 0]);
});

test('R turns with the pointer about the line of sight, a typed number is in degrees', () => {
  const session = begin('rotate');

  session.pointer(200, 0, NONE); // from right of the pivot to above it
  const free = session.motion();
  assert.ok(free.kind === 'rotate');
  near([free.angle, ...free.axis], [Math.PI / 2, 0, 0, 1]);

  type(session, 'x90');
  const typed = session.motion();
  assert.ok(typed.kind === 'rotate');
  near([typed.angle, ...typed.axis], [Math.PI / 2, 1, 0, 0]);
});

test('about an axis that points away from the viewer the pointer turns the other way round', () => {
  const axes: Basis = [[1, 0, 0], [0, -1, 0], [0, 0, -1]];
  const session = begin('rotate', [300, 100], { ...front, axes });

  session.pointer(200, 0, NONE);
  session.key('z', false);

  const motion = session.motion();
  assert.ok(motion.kind === 'rotate');
  near([motion.angle, ...motion.axis], [-Math.PI / 2, 0, 0, -1]);
});

test('S is the ratio of distances to the pivot; a plane leaves its normal', () => {
  const session = begin('scale');

  session.pointer(400, 100, NONE);
  session.key('Z', true);

  const motion = session.motion();
  assert.ok(motion.kind === 'scale');
  near(motion.factors, [2, 2, 1]);
});

test('an axis that points at the viewer does not run away', () => {
  const session = begin('move');
  session.pointer(310, 100, NONE);

  session.key('z', false);

  assert.ok(Math.abs(offset(session)[2]) <= 0.1);
});

test('snap steps are 1, 2 or 5 times a power of ten', () => {
  assert.equal(snapStep(100), 0.5);
  assert.equal(snapStep(24), 1);
  assert.equal(snapStep(2), 20);
});

test('Tab goes from number to number: G 1 Tab 2 Tab 3, and the last is followed by the first', () => {
  const session = begin('move');

  type(session, '1');
  session.key('Tab', false);
  type(session, '-2.5');
  assert.equal(transformHeadline(session, 'world'), 'Move  1  -2.5|  ·');
  session.key('Tab', false);
  type(session, '3');
  near(offset(session), [1, -2.5, 3]);

  session.key('Tab', false);
  type(session, '0');
  session.key('Tab', true);
  type(session, '4');
  near(offset(session), [10, -2.5, 34]);
});

test('in a plane there are two numbers, along one axis one, and what was typed stays', () => {
  const session = begin('move');
  session.key('Y', true);

  type(session, '1');
  session.key('Tab', false);
  type(session, '2');
  near(offset(session), [1, 0, 2]);

  session.key('z', false);
  near(offset(session), [0, 0, 1]);
  session.key('Tab', false); // the only one again
  type(session, '5');
  near(offset(session), [0, 0, 15]);
});

test('one factor scales all axes, Tab makes them differ and leaves at 1 what has none', () => {
  const session = begin('scale');
  const factors = (): readonly number[] => {
    const motion = session.motion();
    assert.ok(motion.kind === 'scale');
    return motion.factors;
  };

  type(session, '.5');
  near(factors(), [0.5, 0.5, 0.5]);
  session.key('Tab', false);
  type(session, '3');
  near(factors(), [0.5, 3, 1]);
});

test('R R rolls a ball below the pointer, R again or an axis goes back, and two numbers are typed', () => {
  const session = begin('rotate');
  const turn = (): readonly number[] => {
    const motion = session.motion();
    assert.ok(motion.kind === 'rotate');
    return motion.axis.map((x) => x * motion.angle);
  };

  session.key('r', false);
  session.pointer(350, 130, NONE); // 50 right, 30 down: a hundred pixels are a radian
  near(turn(), [0.3, 0.5, 0]);
  assert.match(transformHeadline(session, 'world'), /^Trackball {2}33\.4°$/);
  type(session, '90');
  session.key('Tab', false);
  type(session, '-90');
  near(turn(), [Math.PI / 2, -Math.PI / 2, 0]);

  session.key('r', false);
  near(turn(), [0, 0, Math.PI / 2]);
  session.key('r', false);
  session.key('y', false);
  near(turn(), [0, Math.PI / 2, 0]);
});

test('a finger that comes down elsewhere moves nothing until it moves', () => {
  const session = begin('move');

  session.resume(20, 20);
  near(offset(session), [0, 0, 0]);
  session.pointer(70, 20, NONE);

  near(offset(session), [0.5, 0, 0]);
});

test('the headline says what is done, in words', () => {
  const session = begin('move');
  type(session, 'x2');

  assert.equal(transformHeadline(session, 'world'), 'Move  2|   along X (world)');
  session.key('x', false);
  assert.equal(transformHeadline(session, 'view'), 'Move  2|   along u (lattice)');
  assert.equal(transformHeadline(session, 'lattice'), 'Move  2|   along X (world)');
});

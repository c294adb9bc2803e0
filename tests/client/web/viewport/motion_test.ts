// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { FINEST, pixelRatioOf, planFor, type Plan } from '@src/viewport/motion';
import { Refinement } from '@src/viewport/refinement';

const DETAILS = [1_000_000, 250_000, 40_000, 10_000]; // 10 segments: every row, every second, fifth, tenth
const PIXELS = 500_000;

/** Replaces timers; returns a function that lets milliseconds pass. Only one timer runs at a time. */
function fakeTimer(t: TestContext): (ms: number) => void {
  let next: { left: number; then: () => void } | undefined;
  t.mock.method(globalThis, 'setTimeout', (then: () => void, ms: number) => (next = { left: ms, then }));
  t.mock.method(globalThis, 'clearTimeout', () => (next = undefined));
  return (ms) => {
    if (next === undefined || (next.left -= ms) > 0) return;
    const { then } = next;
    next = undefined;
    then();
  };
}

test('a plan keeps the budget of 33 ms by the cheaper means: fewer triangles of many, fewer pixels of a small surface', () => {
  assert.equal(planFor(FINEST, 20, DETAILS, PIXELS), FINEST, 'the same, so that no frame is drawn again');
  assert.deepEqual(planFor(FINEST, 66, DETAILS, PIXELS), { detail: 1, ratio: 0 });
  assert.deepEqual(planFor(FINEST, 200, DETAILS, PIXELS), { detail: 2, ratio: 0 });
  assert.deepEqual(planFor(FINEST, 60, [1000, 250, 40, 10], PIXELS), { detail: 0, ratio: 1 });
  assert.deepEqual(planFor({ detail: 2, ratio: 0 }, 50, DETAILS, PIXELS), { detail: 2, ratio: 1 });
  assert.deepEqual(planFor(FINEST, 1e6, DETAILS, PIXELS), { detail: 3, ratio: 2 }, 'the coarsest, if none keeps it');
  assert.deepEqual(planFor(FINEST, 100, [0], PIXELS), { detail: 0, ratio: 2 }, 'without a surface');
  assert.equal(pixelRatioOf({ detail: 0, ratio: 2 }), 0.5);
});

test('a motion is coarse once frames were slow, never finer, and full 150 ms after it; the next one starts as coarse', (t) => {
  const pass = fakeTimer(t);
  let due = 0;
  const refinement = new Refinement(() => ++due);
  const measured = (plan: Plan, ...times: number[]): void => {
    for (const ms of times) refinement.measured(plan, ms, DETAILS, PIXELS);
  };
  refinement.moved();
  assert.equal(refinement.plan, FINEST);
  measured(FINEST, 200, 200);
  const coarse = refinement.plan;
  assert.equal(coarse.detail, 2);
  measured(FINEST, 1000, 1000);
  assert.equal(refinement.plan, coarse, 'frames of an earlier plan say nothing');
  measured(coarse, 5, 5, 5);
  assert.deepEqual(refinement.plan, coarse);

  pass(149);
  refinement.changed();
  assert.equal(refinement.pace, 'moving');
  pass(1);
  assert.deepEqual([refinement.pace, refinement.plan, due], ['resting', FINEST, 1]);
  refinement.moved();
  assert.deepEqual(refinement.plan, coarse);
});

test('one frame that was held up does not make a motion coarse; two of three that are slow do', () => {
  const refinement = new Refinement(() => undefined);
  const planAfter = (...times: number[]): Plan => {
    for (const ms of times) refinement.measured(FINEST, ms, DETAILS, PIXELS);
    return refinement.plan;
  };
  refinement.moved();

  assert.equal(planAfter(400), FINEST, 'the first');
  assert.equal(planAfter(8, 8, 400), FINEST, 'a later one');
  assert.equal(planAfter(8, 8, 400), FINEST, 'another one');
  assert.deepEqual(planAfter(400), { detail: 2, ratio: 1 });
});

test('frames are antialiased once nothing has changed for 400 ms', (t) => {
  const pass = fakeTimer(t);
  const refinement = new Refinement(() => undefined);
  refinement.changed();
  pass(399);
  refinement.changed();
  pass(399);
  assert.equal(refinement.pace, 'resting');
  pass(1);
  assert.equal(refinement.pace, 'settled');
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// When levels of edges are chosen anew.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { LevelPace } from '@src/patches/levels/level_pace';

/** Frames: what the tolerance is, whether control points move, when; and then whether levels are due, and lazy. */
type Frame = readonly [tolerance: string, isEditing: boolean, now: number, isDue: boolean, isLazy: boolean];

const CASES: Readonly<Record<string, readonly Frame[]>> = {
  'the first frame chooses, and one that shows the same does not': [['a', false, 0, true, true], ['a', false, 16, true, false], ['a', false, 32, false, false]],
  'a moving camera chooses every 150 ms, lazily, and once more at rest': [
    ['a', false, 0, true, true], ['a', false, 16, true, false],
    ['b', false, 100, false, true], ['c', false, 140, false, true], ['d', false, 150, true, true], ['e', false, 160, false, true],
    ['e', false, 310, true, true], ['e', false, 320, true, false], ['e', false, 330, false, false]],
  'a camera that comes back to where levels were chosen chooses again, since some may be too fine': [
    ['a', false, 0, true, true], ['a', false, 16, true, false], ['b', false, 20, false, true], ['a', false, 40, true, false]],
  'an edit that begins or ends chooses at once, and not lazily': [
    ['a', false, 0, true, true], ['a', false, 16, true, false], ['2a', true, 20, true, false], ['2a', true, 30, false, false],
    ['a', false, 180, true, false], ['a', false, 200, false, false]],
};

for (const [name, frames] of Object.entries(CASES)) {
  test(name, () => {
    const pace = new LevelPace();
    for (const [tolerance, isEditing, now, isDue, isLazy] of frames) {
      assert.deepEqual(pace.frame(tolerance, isEditing, now), { isDue, isLazy }, `${now} ms`);
    }
  });
}

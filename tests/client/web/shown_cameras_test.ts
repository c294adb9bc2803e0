// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Two windows that follow each other, whenever their news arrive.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ShownCameras } from '@src/shown_cameras';
import type { CameraPose } from '@src/state/camera_pose';

const camera = (x: number): CameraPose => ({ position: [x, -5, 0], target: [x, 0, 0], up: [0, 0, 1], projection: { fovY: 40 } });

/** mulberry32 */
function randomOf(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

interface Window {
  readonly news: CameraPose[]; // on their way to the other one, the oldest first
  readonly shown: ShownCameras;
  goal: CameraPose;
  follows: boolean;
  seen: CameraPose; // what it knows of the other one
}

function windowAt(x: number, seen: CameraPose): Window {
  const news: CameraPose[] = [];
  const shown = new ShownCameras((pose) => news.push(pose));
  shown.stand(camera(x));
  return { news, shown, goal: camera(x), follows: false, seen };
}

test('two who follow each other come to the same camera, and stop showing others', () => {
  for (let seed = 1; seed <= 2000; ++seed) {
    const random = randomOf(seed);
    const windows = [windowAt(1, camera(20)), windowAt(2, camera(10))] as const;
    let count = 0;
    const look = (i: 0 | 1): void => {
      const one = windows[i];
      if (one.follows) one.goal = one.shown.goal(one.seen, i === 0);
    };
    for (let step = 0; step < 400; ++step) {
      const i = random() < 0.5 ? 0 : 1;
      const one = windows[i];
      if (!one.follows && random() < 0.2) {
        one.follows = true;
        look(i);
      } else if (!one.follows && random() < 0.2) {
        one.goal = camera(3 + step);
        one.shown.stand(one.goal);
      } else if (windows[1 - i]!.news.length > 0) {
        const { news } = windows[1 - i]!;
        const skipped = Math.floor(random() * news.length); // presence may skip to the newest
        one.seen = news.splice(0, skipped + 1).at(-1)!;
        ++count;
        look(i);
      }
    }
    assert.deepEqual(windows.map(({ news }) => news.length), [0, 0], `seed ${seed}`);
    assert.deepEqual(windows[0].goal, windows[1].goal, `seed ${seed}`);
    assert.ok(count < 100, `seed ${seed}: ${count} cameras`);
  }
});

test('a camera that is followed is shown to others once; a window that stands shows its own', () => {
  const shown: number[] = [];
  const cameras = new ShownCameras(({ position }) => shown.push(position[0]));
  cameras.stand(camera(1));
  for (const x of [2, 2, 3, 2]) assert.deepEqual(cameras.goal(camera(x), false), camera(x));
  assert.deepEqual(shown, [1, 2, 3]);
  cameras.stand(camera(4));
  cameras.goal(camera(2), false);
  assert.deepEqual(shown, [1, 2, 3, 4, 2]);
});

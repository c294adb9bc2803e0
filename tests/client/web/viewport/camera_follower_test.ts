// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Following another camera: what it sees, the way there, and what ends it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { PerspectiveCamera, Vector3 } from 'three';
import { add, distance, length, scale } from '@src/lattice/vec';
import type { CameraPose } from '@src/state/camera_pose';
import { CameraFollower } from '@src/viewport/camera_follower';
import { between, looksLike, sightOf, type Sight } from '@src/viewport/sight';

const FRAME_MS = 16;
const FRONT: Sight = { target: [0, 0, 0], from: [0, -1, 0], height: 2 };
const SIDE: Sight = { target: [1, 0, 3], from: [1, 0, 0], height: 8 };

/** A camera with a lens of 90 degrees. */
class FakeRig {
  readonly camera = new PerspectiveCamera(90);
  readonly target = new Vector3();
  shown = 0;

  constructor() {
    this.show(FRONT);
    this.shown = 0;
  }

  pose(): CameraPose {
    const [position, target] = [this.camera.position.toArray(), this.target.toArray()];
    return { position, target, up: [0, 0, 1], projection: { fovY: 90 } };
  }

  show({ target, from, height }: Sight): void {
    ++this.shown;
    this.target.set(...target);
    this.camera.position.set(...add(target, scale(from, height / 2)));
  }

  get sight(): Sight {
    return sightOf(this.pose());
  }
}

function following(isEased = true): { rig: FakeRig; follower: CameraFollower; moves: number[]; pass: (frames: number) => void } {
  const rig = new FakeRig();
  const moves: number[] = [];
  let now = 0;
  const follower = new CameraFollower(rig, () => moves.push(now), () => isEased);
  const pass = (frames: number): void => {
    for (let i = 0; i < frames; ++i) follower.frame((now += FRAME_MS));
  };
  return { rig, follower, moves, pass };
}

test('a sight says how much is seen, in perspective and without', () => {
  const place = { position: [0, -4, 0], target: [0, 0, 0], up: [0, 0, 1] } as const;

  assert.ok(Math.abs(sightOf({ ...place, projection: { fovY: 90 } }).height - 8) < 1e-12);
  assert.equal(sightOf({ ...place, projection: { height: 3 } }).height, 3);
  assert.deepEqual(sightOf({ ...place, projection: { height: 3 } }).from, [0, -1, 0]);
});

test('the way leads around the target, also to the opposite side', () => {
  const half = between(FRONT, SIDE, 0.5);
  assert.ok(distance(half.from, [Math.SQRT1_2, -Math.SQRT1_2, 0]) < 1e-12);
  assert.deepEqual([half.target, half.height], [[0.5, 0, 1.5], 4]);

  for (const from of [[0, 1, 0], [0, -1, 0]] as const) {
    const there = between(FRONT, { ...FRONT, from }, 1);
    assert.ok(distance(there.from, from) < 1e-12);
    assert.ok(Math.abs(length(between(FRONT, { ...FRONT, from }, 0.5).from) - 1) < 1e-12);
  }
});

test('the camera goes smoothly to the other one, and no frame moves it once it is there', () => {
  const { rig, follower, moves, pass } = following();
  follower.follow(SIDE);
  pass(1);
  const first = distance(rig.sight.from, SIDE.from);
  assert.ok(first > 0.8 * distance(FRONT.from, SIDE.from), 'no jump');
  pass(31);
  assert.ok(distance(rig.sight.from, SIDE.from) < 0.02 * first, 'half a second later');
  pass(100);
  assert.ok(looksLike(rig.sight, SIDE));
  const { shown } = rig;
  pass(100);

  assert.equal(rig.shown, shown);
  assert.deepEqual(moves, [], 'it moves itself');
});

test('the camera stays with the other one, from rest without a jump', () => {
  const { rig, follower, pass } = following();
  follower.follow(SIDE);
  pass(1000);
  follower.follow(FRONT);
  pass(1);
  assert.ok(distance(rig.sight.from, SIDE.from) < 0.3, 'the time at rest does not count');
  pass(200);
  assert.ok(looksLike(rig.sight, FRONT));
});

test('with reduced motion the camera jumps', () => {
  const { rig, follower, pass } = following(false);
  follower.follow(SIDE);
  pass(1);
  assert.ok(looksLike(rig.sight, SIDE));
});

const FAR = 1e15; // where numbers are an eighth apart
const UNSEEN: readonly (readonly [string, Sight])[] = [
  ['with no height', sightOf({ position: [FAR, 0, 0], target: [FAR, 0, 0], up: [0, 0, 1], projection: { fovY: 40 } })],
  ['too fine for its place', sightOf({ position: [FAR + 0.25, 0, 0], target: [FAR, 0, 0], up: [0, 0, 1], projection: { fovY: 40 } })],
  ['with an infinite height', { ...SIDE, height: Infinity }],
];

for (const [what, unseen] of UNSEEN) {
  test(`a sight ${what} is not followed, and the next one is`, () => {
    const { rig, follower, moves, pass } = following();
    follower.follow(unseen);
    pass(10);
    assert.equal(rig.shown, 0);

    follower.follow(SIDE);
    pass(200);
    assert.ok(looksLike(rig.sight, SIDE));
    assert.deepEqual(moves, []);
  });
}

test('a camera that sees nothing jumps', () => {
  const { rig, follower, moves, pass } = following();
  rig.target.set(FAR, 0, 0);
  rig.camera.position.set(FAR, 0, 0);
  follower.follow(SIDE);
  pass(10);

  assert.ok(looksLike(rig.sight, SIDE));
  assert.deepEqual([rig.shown, moves], [1, []]);
});

test('a move of its own ends the following, and is told; without following it is told too', () => {
  const { rig, follower, moves, pass } = following();
  follower.follow(SIDE);
  pass(3);
  rig.camera.position.x += 0.001;
  const { shown } = rig;
  pass(10);
  assert.equal(rig.shown, shown);
  assert.equal(moves.length, 1);

  rig.target.z = 2;
  pass(10);
  assert.equal(moves.length, 2);
});

test('a move of its own between a frame and the next message is noticed', () => {
  const { rig, follower, moves, pass } = following();
  follower.follow(SIDE);
  pass(3);
  rig.target.z = 2;
  follower.notice();
  assert.equal(moves.length, 1);
  pass(10);
  assert.equal(rig.target.z, 2);
});

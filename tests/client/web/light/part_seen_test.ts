// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Box3, OrthographicCamera, PerspectiveCamera, Vector2, Vector3, Vector4 } from 'three';
import { partSeen } from '@src/light/part_seen';

const SIZE = new Vector2(300, 200);
const MARGIN = 4;

function corners({ min, max }: Box3): Vector3[] {
  return Array.from({ length: 8 }, (_, i) =>
    new Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z));
}

for (const [name, camera] of [
  ['perspective', new PerspectiveCamera(40, 1.5, 0.1, 100)], ['orthographic', new OrthographicCamera(-3, 3, 2, -2, 0.1, 100)],
] as const) {
  camera.position.set(4, -5, 3);
  camera.up.set(0, 0, 1);
  camera.lookAt(0, 0, 0);
  camera.updateMatrixWorld();
  camera.updateProjectionMatrix();

  test(`the part that a ${name} camera shows holds the box and its margin, and hardly more`, () => {
    const box = new Box3(new Vector3(-0.5, -1, -0.25), new Vector3(1, 0.5, 0.75));

    const { x, y, z: width, w: height } = partSeen(camera, box, SIZE, MARGIN, new Vector4());

    const seen = corners(box).map((corner) => corner.project(camera));
    const [across, up] = [seen.map((at) => (0.5 + at.x / 2) * SIZE.x), seen.map((at) => (0.5 + at.y / 2) * SIZE.y)];
    for (const [begin, end, places] of [[x, x + width, across], [y, y + height, up]] as const) {
      const [low, high] = [Math.min(...places) - begin, end - Math.max(...places)];
      for (const beyond of [low, high]) assert.ok(beyond >= MARGIN && beyond < MARGIN + 1, `${beyond} pixels`);
    }
    for (const edge of [x, y, width, height]) assert.ok(Number.isInteger(edge));
  });

  test(`of a box that is larger than the view of a ${name} camera the part is the whole picture`, () => {
    const box = new Box3(new Vector3(-3, -3, -3), new Vector3(3, 3, 2.5));
    assert.deepEqual(partSeen(camera, box, SIZE, MARGIN, new Vector4()).toArray(), [0, 0, SIZE.x, SIZE.y]);
  });

  test(`of a box beside the view of a ${name} camera the part is empty`, () => {
    const aside = new Vector3(1, 0, 0).applyQuaternion(camera.quaternion).multiplyScalar(40);
    const box = new Box3().setFromCenterAndSize(aside, new Vector3(1, 1, 1));
    const part = partSeen(camera, box, SIZE, MARGIN, new Vector4());
    assert.ok(part.z === 0 && part.w >= 0, part.toArray().join());
  });
}

test('where a part of the box is behind the camera the part is the whole picture', () => {
  const camera = new PerspectiveCamera(40, 1.5, 0.1, 100);
  camera.updateMatrixWorld();
  const box = new Box3(new Vector3(-0.1, -0.1, -5), new Vector3(0.1, 0.1, 1));
  assert.deepEqual(partSeen(camera, box, SIZE, MARGIN, new Vector4()).toArray(), [0, 0, SIZE.x, SIZE.y]);
});

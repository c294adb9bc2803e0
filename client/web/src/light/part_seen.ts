// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Vector4, type Box3, type Camera, type Vector2 } from 'three';

/**
 * The part of a picture of `size` pixels that shows a box of the world, with `margin` pixels around, in whole pixels from
 * the lower left: x, y, width, height. All of the picture if a part of the box is behind the camera.
 */
export function partSeen(camera: Camera, box: Box3, size: Vector2, margin: number, part: Vector4): Vector4 {
  const corner = new Vector4();
  let [left, bottom, right, top] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < 8; ++i) {
    corner.set((i & 1 ? box.max : box.min).x, (i & 2 ? box.max : box.min).y, (i & 4 ? box.max : box.min).z, 1);
    corner.applyMatrix4(camera.matrixWorldInverse).applyMatrix4(camera.projectionMatrix);
    if (!(corner.w > 0)) return part.set(0, 0, size.x, size.y);
    const [x, y] = [(0.5 + corner.x / corner.w / 2) * size.x, (0.5 + corner.y / corner.w / 2) * size.y];
    [left, bottom, right, top] = [Math.min(left, x), Math.min(bottom, y), Math.max(right, x), Math.max(top, y)];
  }
  const within = (place: number, end: number): number => Math.min(Math.max(place, 0), end);
  left = within(Math.floor(left) - margin, size.x);
  bottom = within(Math.floor(bottom) - margin, size.y);
  right = within(Math.ceil(right) + margin, size.x);
  top = within(Math.ceil(top) + margin, size.y);
  return part.set(left, bottom, right - left, top - bottom);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Frustum, Matrix4, Vector3, type Box3 } from 'three';
import type { ViewCamera } from './camera_rig';
import { lensOf } from './lens';

/** Calls its argument with boxes that together hold a surface. */
export type EachBox = (visit: (box: Box3) => void) => void;

/**
 * The length in the world that one pixel shows, where the part of the surface in view is nearest. A displacement of this
 * length moves no point of the picture by more than a pixel:
 *
 *   perspective    depth / (focal length in pixels * sqrt(1 + tan^2 of the angle to the picture's corner)), since away from
 *                  the middle the picture is stretched
 *   orthographic   the same everywhere
 *
 * Undefined if nothing is in view.
 *
 * @param height Of the picture, in pixels.
 */
export function pixelSize(camera: ViewCamera, height: number, eachBox: EachBox): number | undefined {
  camera.updateMatrixWorld();
  const { focal, stretch, isPerspective } = lensOf(camera, height);
  const depth = nearestDepth(camera, eachBox);
  if (depth === undefined) return undefined;
  return (isPerspective ? depth : 1) / (focal * Math.sqrt(stretch));
}

/** The depth of the nearest box in view; no less than that of the near plane. */
function nearestDepth(camera: ViewCamera, eachBox: EachBox): number | undefined {
  const toView = camera.matrixWorldInverse;
  const seen = new Frustum().setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, toView));
  const [x, y, z, offset] = [2, 6, 10, 14].map((i) => -toView.elements[i]!) as [number, number, number, number];
  const middle = new Vector3();
  const size = new Vector3();
  let nearest: number | undefined;
  eachBox((box) => {
    if (!seen.intersectsBox(box)) return;
    box.getCenter(middle);
    box.getSize(size);
    const depth = x * middle.x + y * middle.y + z * middle.z + offset -
      (Math.abs(x) * size.x + Math.abs(y) * size.y + Math.abs(z) * size.z) / 2;
    nearest = Math.min(nearest ?? Infinity, Math.max(depth, camera.near));
  });
  return nearest;
}

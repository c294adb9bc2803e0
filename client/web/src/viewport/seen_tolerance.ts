// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Vector3 } from 'three';
import type { SeenTolerance } from '../patches/levels/chosen_levels';
import type { ViewCamera } from './camera_rig';
import { lensOf } from './lens';

/**
 * How far points may be from the surface, so that none is drawn more than `pixels` away from where it should be:
 *
 *   perspective    pixels / (focal length in pixels * (1 + tan^2 of the angle to the picture's corner)) times the distance
 *                  from the eye. Away from the middle the picture is stretched by 1 / cos^2 of the angle
 *   orthographic   the same everywhere
 *
 * @param height Of the picture, in pixels.
 */
export function seenTolerance(camera: ViewCamera, height: number, pixels: number): SeenTolerance {
  camera.updateMatrixWorld();
  const { focal, stretch, isPerspective } = lensOf(camera, height);
  if (!isPerspective) return { everywhere: pixels / focal };
  const { x, y, z } = new Vector3().setFromMatrixPosition(camera.matrixWorld);
  return { eye: [x, y, z], perDistance: pixels / (focal * stretch), nearest: camera.near };
}

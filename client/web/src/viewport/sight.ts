// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a camera sees, whichever lens it has: a point from a side, so many world units high. All functions are pure.
import { add, cross, distance, dot, length, normalized, scale, sub, type Vec3 } from '../lattice/vec';
import type { CameraPose } from '../state/camera_pose';

export interface Sight {
  /** The point in the middle of the picture. */
  readonly target: Vec3;
  /** The unit vector from the target to the eye. */
  readonly from: Vec3;
  /** The height of the picture at the target, in world units. */
  readonly height: number;
}

const NEAR = 1e-5; // far below a pixel, of the picture's height and in radians
const TOO_FINE = 1e-9; // of the target's distance from the origin: there NEAR is still some 50 times what a number can tell

export function sightOf({ position, target, projection }: CameraPose): Sight {
  const offset = sub(position, target);
  const height = 'fovY' in projection ? 2 * length(offset) * Math.tan((projection.fovY * Math.PI) / 360) : projection.height;
  return { target, from: normalized(offset), height };
}

/** Whether numbers can tell what is seen from its surroundings. Far from the origin the smallest pictures cannot be told. */
export function isSeen({ target, height }: Sight): boolean {
  return Number.isFinite(height) && height > TOO_FINE * length(target);
}

/** The sight between two that are seen, at a fraction of the way: around the target rather than through it. */
export function between(a: Sight, b: Sight, fraction: number): Sight {
  return {
    target: add(a.target, scale(sub(b.target, a.target), fraction)),
    from: turned(a.from, b.from, fraction),
    height: a.height * (b.height / a.height) ** fraction,
  };
}

/** Whether nobody can tell the two apart. */
export function looksLike(a: Sight, b: Sight): boolean {
  const isSameSize = Math.abs(Math.log(a.height / b.height)) <= NEAR;
  return isSameSize && distance(a.target, b.target) <= NEAR * b.height && angle(a.from, b.from) <= NEAR;
}

function angle(a: Vec3, b: Vec3): number {
  return Math.atan2(length(cross(a, b)), dot(a, b));
}

/** The direction at a fraction of the arc from `a` to `b`. Between opposite ones it is any arc. */
function turned(a: Vec3, b: Vec3, fraction: number): Vec3 {
  const normal = normalized(cross(a, b));
  const axis = length(normal) > 0 ? normal : normalized(cross(a, Math.abs(a[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
  const step = angle(a, b) * fraction;
  return add(scale(a, Math.cos(step)), scale(cross(axis, a), Math.sin(step)));
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Converts between the world and pixels of the view.
import { Matrix4, Raycaster, Vector2, Vector3 } from 'three';
import type { ScreenJacobian } from '../edit/constraint';
import { sub, type Vec3 } from '../lattice/vec';
import type { ViewCamera } from './camera_rig';

export interface ScreenSize {
  width: number;
  height: number;
}

export interface Ray {
  origin: Vec3;
  direction: Vec3;
}

/** A world point in pixels from the top left, with its depth from -1 (near) to 1 (far); undefined behind the camera. */
export function project(camera: ViewCamera, size: ScreenSize, p: Vec3): Vec3 | undefined {
  const pixels = projectAll(camera, size, p);
  return Number.isNaN(pixels[0]) ? undefined : [pixels[0], pixels[1], pixels[2]];
}

/** All points in pixels: x, y and depth of each; NaN behind the camera. */
export function projectAll(camera: ViewCamera, size: ScreenSize, points: ArrayLike<number>): Float64Array {
  const m = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).elements;
  const out = new Float64Array(points.length);
  for (let i = 0; i < points.length; i += 3) {
    const [x, y, z] = [points[i], points[i + 1], points[i + 2]];
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    const scale = w > 0 ? 1 / w : NaN;
    out[i] = ((m[0] * x + m[4] * y + m[8] * z + m[12]) * scale * 0.5 + 0.5) * size.width;
    out[i + 1] = (0.5 - (m[1] * x + m[5] * y + m[9] * z + m[13]) * scale * 0.5) * size.height;
    out[i + 2] = (m[2] * x + m[6] * y + m[10] * z + m[14]) * scale;
  }
  return out;
}

/** The ray under a pixel. */
export function rayAt(camera: ViewCamera, size: ScreenSize, x: number, y: number): Ray {
  const caster = new Raycaster();
  caster.setFromCamera(new Vector2((x / size.width) * 2 - 1, 1 - (y / size.height) * 2), camera);
  return { origin: caster.ray.origin.toArray() as Vec3, direction: caster.ray.direction.toArray() as Vec3 };
}

/** Pixels per world unit at `p`, by central differences over a thousandth of the camera's distance. */
export function jacobianAt(camera: ViewCamera, size: ScreenSize, p: Vec3): ScreenJacobian {
  const step = camera.position.distanceTo(new Vector3(...p)) / 1000 || 1e-3;
  const rows: [number[], number[]] = [[], []];
  for (let axis = 0; axis < 3; ++axis) {
    const ends = [-step / 2, step / 2].map((h) => {
      const q = [...p] as [number, number, number];
      q[axis] += h;
      return project(camera, size, q) ?? ([0, 0, 0] as Vec3);
    });
    const [dx, dy] = sub(ends[1], ends[0]);
    rows[0].push(dx / step);
    rows[1].push(dy / step);
  }
  return rows as unknown as ScreenJacobian;
}

/** Pixels of one world unit across the line of sight, at `p`. */
export function pixelsPerUnit(camera: ViewCamera, size: ScreenSize, p: Vec3): number {
  const [x, y] = jacobianAt(camera, size, p);
  const e = camera.matrixWorld.elements;
  return Math.hypot(x[0] * e[0] + x[1] * e[1] + x[2] * e[2], y[0] * e[0] + y[1] * e[1] + y[2] * e[2]);
}

/** The nearest projected point within `radius` pixels of (x, y); of two points at one place, the one in front. */
export function nearestPoint(
  projected: Float64Array,
  x: number,
  y: number,
  radius: number,
  eligible: (index: number) => boolean,
): number | undefined {
  let best: number | undefined;
  let least = Infinity;
  for (let i = 0; i < projected.length / 3; ++i) {
    const away = Math.hypot(projected[3 * i] - x, projected[3 * i + 1] - y);
    if (!(away <= radius) || !eligible(i)) continue;
    // Depth counts as at most 3 pixels, so the front one of overlapping points is taken.
    const cost = away + 3 * projected[3 * i + 2];
    if (cost < least) [best, least] = [i, cost];
  }
  return best;
}

/** The projected points inside a rectangle given by two corners. */
export function pointsInBox(
  projected: Float64Array,
  a: readonly [number, number],
  b: readonly [number, number],
  eligible: (index: number) => boolean,
): number[] {
  const inside = (v: number, s: number, t: number): boolean => v >= Math.min(s, t) && v <= Math.max(s, t);
  const found: number[] = [];
  for (let i = 0; i < projected.length / 3; ++i) {
    if (inside(projected[3 * i], a[0], b[0]) && inside(projected[3 * i + 1], a[1], b[1]) && eligible(i)) found.push(i);
  }
  return found;
}

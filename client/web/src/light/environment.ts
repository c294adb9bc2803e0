// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A studio as an image around the view: a sky and a floor, and lamps with soft edges. Directions are unit vectors of the
// view: x right, y up, z towards the eye. The studio turns with the camera, so the visible side is never dark.
import { SphericalHarmonics3, Vector3 } from 'three';

export interface Lamp {
  readonly from: readonly [number, number, number];
  /** The cosine of its radius, seen from the middle. */
  readonly edge: number;
  readonly radiance: number;
}

export interface Environment {
  readonly sky: number;
  readonly floor: number;
  readonly lamps: readonly Lamp[];
}

const DIRECTIONS = 1024; // of the sum that stands for an integral over the sphere

/** The light that comes from a direction; `blur`, 0 to 1, widens every edge, as a rough surface does. */
export function radianceFrom({ sky, floor, lamps }: Environment, direction: Vector3, blur: number): number {
  const horizon = 0.1 + blur;
  let sum = floor + (sky - floor) * smoothstep(-horizon, horizon, direction.y);
  for (const { from, edge, radiance } of lamps) {
    const toMiddle = (direction.x * from[0] + direction.y * from[1] + direction.z * from[2]) / Math.hypot(...from);
    const width = 0.03 + blur * (1 - edge);
    sum += radiance * smoothstep(edge - width, edge + width, toMiddle);
  }
  return sum;
}

/**
 * The light that a matt surface reflects by its normal, as spherical harmonics of order 2 (Ramamoorthi & Hanrahan 2001,
 * doi:10.1145/383259.383317). White reflects `irradianceAt(…) / pi`.
 */
export function irradianceOf(environment: Environment): SphericalHarmonics3 {
  const harmonics = new SphericalHarmonics3();
  const basis = new Array<number>(9);
  for (const direction of sphere(DIRECTIONS)) {
    const share = (radianceFrom(environment, direction, 0) * 4 * Math.PI) / DIRECTIONS;
    SphericalHarmonics3.getBasisAt(direction, basis);
    harmonics.coefficients.forEach((coefficient, i) => coefficient.addScalar(basis[i] * share));
  }
  return harmonics;
}

/** Directions that are spread evenly: a spiral of Fibonacci. */
function sphere(count: number): Vector3[] {
  const turn = Math.PI * (3 - Math.sqrt(5));
  return Array.from({ length: count }, (_, i) => {
    const y = 1 - (2 * i + 1) / count;
    const radius = Math.sqrt(1 - y * y);
    return new Vector3(radius * Math.cos(turn * i), y, radius * Math.sin(turn * i));
  });
}

export function smoothstep(low: number, high: number, x: number): number {
  const t = Math.min(Math.max((x - low) / (high - low), 0), 1);
  return t * t * (3 - 2 * t);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The normals that a page has received, of FACET and SMOOTH (view.proto), against the definition: those of the rest shape
// carried by the cofactors of the deformation's Jacobian, which differences give here.
import assert from 'node:assert/strict';
import type { Page } from 'playwright-core';
import { add, cross, distance, dot, normalized, scale, sub, type Vec3 } from '@src/lattice/vec';
import type { Lattice } from '@src/lattice/lattice';
import { deformed, settled, shownBy, verticesOf } from './definition';

const STEP = 1e-4; // of differences, in world units

/** At a vertex: the normals that points there may have, each of which some point has. */
interface Expected {
  readonly place: Vec3;
  readonly normals: readonly Vec3[];
}

function carried(lattice: Lattice, p: Vec3, normal: Vec3): Vec3 {
  const ends = (h: number) => ([[h, 0, 0], [0, h, 0], [0, 0, h]] as const).map((way) => deformed(lattice, add(p, way)));
  const [low, high] = [ends(-STEP), ends(STEP)];
  const [a, b, c] = high.map((end, axis) => sub(end, low[axis]));
  return normalized(add(add(scale(cross(b, c), normal[0]), scale(cross(c, a), normal[1])), scale(cross(a, b), normal[2])));
}

/** Twice the areas of triangles and planar faces around each vertex, as vectors along their normals. */
function facesAround(obj: string): Vec3[][] {
  const vertices = verticesOf(obj);
  const around: Vec3[][] = vertices.map(() => []);
  for (const line of obj.split('\n').filter((text) => text.startsWith('f '))) {
    const corners = line.slice(2).split(' ').map((corner) => parseInt(corner, 10) - 1);
    const [first, ...rest] = corners.map((i) => vertices[i]);
    const parts = rest.slice(1).map((end, i) => cross(sub(rest[i], first), sub(end, first)));
    for (const i of corners) around[i].push(parts.reduce(add));
  }
  return around;
}

function expected(lattice: Lattice, obj: string, mode: 'facet' | 'smooth'): Expected[] {
  const around = facesAround(obj);
  return verticesOf(obj).map((p, i) => {
    const rest = mode === 'facet' ? around[i] : [around[i].reduce(add)];
    return { place: deformed(lattice, p), normals: rest.map((normal) => carried(lattice, p, normal)) };
  });
}

/** Of two numbers on the octahedral map, or of floats. */
function decodedNormal(numbers: readonly number[], bits: number): Vec3 {
  if (numbers.length === 3) return numbers as unknown as Vec3;
  const most = 2 ** bits - 2;
  let [y, z] = numbers.map((s) => (2 * s) / most - 1);
  const x = 1 - Math.abs(y) - Math.abs(z);
  if (x < 0) [y, z] = [y + (y < 0 ? -x : x), z + (z < 0 ? -x : x)];
  return normalized([x, y, z]);
}

/** Largest angle, in degrees, between a normal received at a vertex and one that it may be, or the reverse. */
async function worstNormal(page: Page, obj: string, mode: 'facet' | 'smooth'): Promise<number> {
  const { lattice, points, normals, step } = await shownBy(page);
  const bits = await page.evaluate(() => window.latticed.settings.value.view.normalBits);
  const angle = (a: Vec3, b: Vec3): number => (180 / Math.PI) * Math.acos(Math.min(1, dot(a, b)));
  const worst = expected(lattice, obj, mode).map(({ place, normals: wanted }) => {
    const got = normals.filter((_, i) => distance(points[i], place) < 2 * step).map((numbers) => decodedNormal(numbers, bits));
    const miss = (one: Vec3, others: readonly Vec3[]): number => Math.min(Infinity, ...others.map((other) => angle(one, other)));
    return Math.max(...got.map((one) => miss(one, wanted)), ...wanted.map((one) => miss(one, got)));
  });
  return Math.max(...worst);
}

/** Waits until the normals at every vertex are those of the definition, to so many degrees. */
export async function normalsFollowDefinition(page: Page, obj: string, mode: 'facet' | 'smooth', degrees: number): Promise<void> {
  const worst = await settled(() => worstNormal(page, obj, mode), (angle) => angle <= degrees);
  assert.ok(worst <= degrees, `${mode}: ${worst} degrees`);
}

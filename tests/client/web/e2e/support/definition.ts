// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the surface that a page shows with the definition of the deformation: B-spline volumes in double precision.
import assert from 'node:assert/strict';
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { evaluate } from '@src/lattice/bspline';
import { domain, frameEdges } from '@src/lattice/grid';
import { knotVectors } from '@src/lattice/identity';
import { Lattice } from '@src/lattice/lattice';
import { coordinates, distance, sub, type Vec3 } from '@src/lattice/vec';
import { numbersFrom, triples } from './numbers';
import { sourcePlaces, type Spot } from './source_places';

const FLOAT_STEP = 1e-5; // the error of floats, on meshes of a few units

/** The lattice that a page shows, and every point that it has received. */
export interface Shown {
  readonly lattice: Lattice;
  readonly topology: string;
  /** The points of each patch in turn. */
  readonly points: readonly Vec3[];
  /** Of each point its patch, and its barycentrics there. */
  readonly spots: readonly Spot[];
  /** The step of the position grid, in world units; for floats their error. Where the page evaluates points, a step of 16 bits. */
  readonly step: number;
}

export async function shownBy(page: Page): Promise<Shown> {
  const { few, lists } = (await numbersFrom(page, (floatStep) => {
    const { scene } = window.latticed;
    const { surface } = scene!.session;
    const { min, max } = surface.bounds;
    const sixteenBits = Math.max(max.x - min.x, max.y - min.y, max.z - min.z) / 65_535;
    const layout = surface.layout!;
    const points: number[] = [];
    const patches: number[] = [];
    const weights: number[] = [];
    surface.places.eachPatch(1, (patch, pattern, firstPoint) => pattern.points.forEach((entry, n) => {
      const [i1, i2] = [entry & 0xffff, entry >>> 16];
      points.push(...surface.positionOf(firstPoint + n));
      patches.push(patch);
      weights.push(...[layout.whole - i1 - i2, i1, i2].map((i) => i / layout.whole));
    }));
    const { frame, degree, size, knots, points: controlPoints } = window.latticed.scene!.session.lattice;
    return {
      few: {
        topology: layout.id,
        step: scene!.isEvaluated ? sixteenBits : surface.grid?.step === 1 ? floatStep : surface.grid!.step,
        lattice: { frame, degree, size, knots: knots.map((k) => [...k]) },
      },
      lists: { points, patches, weights, controlPoints },
    };
  }, FLOAT_STEP))!;
  const { topology, step, lattice: { frame, degree, size, knots } } = few;
  const weights = triples(lists.weights);
  return {
    topology, step,
    points: triples(lists.points),
    spots: weights.map((barycentrics, i) => ({ patch: lists.patches[i], weights: barycentrics })),
    lattice: new Lattice(frame, degree, size, knotVectors((axis) => Float64Array.from(knots[axis])), lists.controlPoints),
  };
}

/** The position to which the lattice moves a point of the world. */
export function deformed(lattice: Lattice, p: Vec3): Vec3 {
  const x = coordinates(frameEdges(lattice.frame), sub(p, lattice.frame.origin));
  const parameter = ([0, 1, 2] as const).map(
    (a) => domain(lattice, a)[0] + x[a] * (domain(lattice, a)[1] - domain(lattice, a)[0]),
  );
  return evaluate(lattice, parameter as unknown as Vec3);
}

const WORST_MISS = 0.9; // grid steps: half a step along each axis makes 0.87; floats add a little
const UNCOVERED = 1e-6;

/** The largest distance, in grid steps, of a point of a patch from the position that the definition gives. */
async function worstPoint(page: Page, obj: string): Promise<number> {
  const { topology, spots, points, step, lattice } = await shownBy(page);
  const source = await sourcePlaces(page, topology, spots, obj);
  if (source === undefined || source.places.length !== points.length) return Infinity; // a newer topology is on its way
  assert.ok(source.uncovered < UNCOVERED, `patches are ${source.uncovered} of a face from covering the mesh once`);
  return source.places.reduce((worst, place, i) => {
    const miss = distance(points[i], deformed(lattice, place)) / step;
    return miss <= worst ? worst : miss; // NaN counts as the worst
  }, 0);
}

/**
 * Waits until every point of every patch is where the definition says. On a busy machine an update may take long.
 * @param obj The page's mesh, of triangles.
 */
export async function followsDefinition(page: Page, obj: string): Promise<void> {
  for (const end = Date.now() + 60_000; ; await page.waitForTimeout(100)) { // leaves the machine to the page meanwhile
    const worst = await worstPoint(page, obj);
    if (worst < WORST_MISS) return;
    assert.ok(Date.now() < end, `${worst} steps`);
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the surface that a page evaluates by itself with the server's evaluation in double precision.
import assert from 'node:assert/strict';
import type { Page } from 'playwright-core';
import { until } from '../../support/until';
import { shownBy } from '../support/definition';
import { numbersFrom } from '../support/numbers';
import { sourcePlaces } from '../support/source_places';
import { direct } from '../support/stage';
import { frames } from '../support/viewer_page';

const MOST_APART = 4e-5; // half a unit of 16 bits on each axis of a lattice of 3 units
const MOST_TURNED = 2e-4; // radians: normals at rest have 2 x 16 bits

/** Waits until the page has evaluated a surface, shows all of it, and the server's update of the newest edit has come. */
export async function evaluated(of: Page): Promise<void> {
  await until(async () => {
    await frames(of); // the first one takes in an edit: until its update comes, no error is known
    return of.evaluate(() => {
      const { scene } = window.latticed;
      return scene?.isEvaluated && scene.session.surface.pointCount > 0 && scene.session.surface.certifiedError > 0;
    });
  });
}

/** Waits until all points that the page shows are the server's, and all normals unless it is told otherwise. */
export async function followsServer(page: Page, obj: string, areNormalsTold = true): Promise<void> {
  let last = '';
  await until(async () => {
    await evaluated(page);
    const { points, worst, worstNormal } = await againstServer(page, obj);
    last = `${points} points, ${worst} units, ${worstNormal} rad`;
    return points > 500 && worst < MOST_APART && (worstNormal < MOST_TURNED || !areNormalsTold);
  }).catch((error: unknown) => assert.fail(`${last}: ${String(error)}`));
}

/** The largest distance of the page's points from the server's, and the largest angle of their normals. `obj`: the page's mesh. */
async function againstServer(page: Page, obj: string): Promise<{ points: number; worst: number; worstNormal: number }> {
  const { topology, spots, points } = await shownBy(page);
  const source = await sourcePlaces(page, topology, spots, obj);
  if (source === undefined) return { points: 0, worst: Infinity, worstNormal: Infinity }; // a newer topology is on its way
  const { normals } = (await numbersFrom(page, () => {
    const { surface } = window.latticed.scene!.session;
    const all: number[] = [];
    const { numbers } = (surface as unknown as { points: { numbers: Float32Array } }).points;
    surface.places.eachPatch(1, (_, pattern, first) => pattern.points.forEach((__, n) => all.push(...numbers.subarray(6 * (first + n) + 3, 6 * (first + n) + 6))));
    return { few: undefined, lists: { normals: all } };
  }, undefined))!.lists;
  const scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  const { surfacePoints } = source;
  let [worst, worstNormal] = [0, 0];
  for (let first = 0; first < points.length; first += 4000) {
    const some = surfacePoints.slice(first, first + 4000);
    const told = await direct.scenes.evaluatePoints({ scene, points: { case: 'surfacePoints', value: { points: some } } });
    some.forEach((_, i) => {
      const n = 3 * (first + i);
      worst = Math.max(worst, Math.hypot(...[0, 1, 2].map((axis) => points[first + i][axis] - told.positions[3 * i + axis])));
      const between = Math.hypot(...[0, 1, 2].map((axis) => normals[n + axis] - told.normals[3 * i + axis]));
      worstNormal = Math.max(worstNormal, 2 * Math.asin(Math.min(between / 2, 1)));
    });
  }
  return { points: points.length, worst, worstNormal };
}

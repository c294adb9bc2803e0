// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface that a page shows, read back, against the definition of the deformation: B-spline volumes in double.
import assert from 'node:assert/strict';
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { evaluate } from '@src/lattice/bspline';
import { domain, frameEdges } from '@src/lattice/grid';
import { latticeFromJson } from '@src/lattice/lattice_json';
import { coordinates, distance, sub, type Vec3 } from '@src/lattice/vec';
import type { SurfaceMesh } from '@src/surface/surface_mesh';

/** Largest distance of a vertex of the mesh, deformed by the definition, from the nearest point received, in grid steps. */
async function worstVertex(page: Page, obj: string): Promise<number> {
  const { points, step, lattice } = await page.evaluate(() => {
    const surface = window.latticed.scene!.session.surface as unknown as SurfaceMesh;
    const layout = surface.drawnLayout!;
    const count = layout.patchCount * layout.pointsPerPatch;
    const { frame, degree, size, knots, points: controls } = window.latticed.scene!.session.lattice;
    return {
      points: Array.from({ length: count }, (_, i) => surface.positionOf(i)),
      step: surface.drawnStep!,
      lattice: { frame, degree, size, knots: knots.map((k) => [...k]), points: [...controls] },
    };
  });
  const { frame, degree, size, knots } = lattice;
  const vector = ([x, y, z]: Vec3) => ({ x, y, z });
  const axes = ([u, v, w]: Vec3) => ({ u, v, w });
  const deformed = latticeFromJson(
    JSON.stringify({
      frame: { origin: vector(frame.origin), u: vector(frame.u), v: vector(frame.v), w: vector(frame.w) },
      degree: axes(degree),
      size: axes(size),
      knotsU: knots[0],
      knotsV: knots[1],
      knotsW: knots[2],
      controlPoints: lattice.points,
    }),
  );
  const rest = obj.split('\n')
    .filter((line) => line.startsWith('v '))
    .map((line) => line.slice(2).split(' ').map(Number) as unknown as Vec3);
  const misses = rest.map((p) => {
    const x = coordinates(frameEdges(deformed.frame), sub(p, deformed.frame.origin));
    const parameter = ([0, 1, 2] as const).map(
      (a) => domain(deformed, a)[0] + x[a] * (domain(deformed, a)[1] - domain(deformed, a)[0]),
    );
    const target = evaluate(deformed, parameter as unknown as Vec3);
    return Math.min(...points.map((q) => distance(q, target)));
  });
  return Math.max(...misses) / step;
}

/** Waits until every vertex is where the definition says: on a busy machine an update takes its time. */
export async function followsDefinition(page: Page, obj: string): Promise<void> {
  let worst = Infinity;
  for (const end = Date.now() + 60_000; worst >= 1 && Date.now() < end; ) worst = await worstVertex(page, obj);
  assert.ok(worst < 1, `${worst} steps`);
}

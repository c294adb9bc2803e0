// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { coordinates, sub, type Basis, type Vec3 } from '@src/lattice/vec';

/** Control points that the surface hides, and those that it shows. A point within a pixel of an edge may be neither. */
export async function behindSurface(page: Page): Promise<{ hidden: number[]; shown: number[] }> {
  const { triangles, rays } = await page.evaluate(() => {
    const { viewport, scene } = window.latticed;
    const surface = scene!.session.surface;
    const corners: Vec3[] = [];
    surface.places.eachPatch(1, (_, { details }, firstPoint) =>
      details[0].forEach((corner) => corners.push(surface.positionOf(firstPoint + corner))));
    const { points, count } = scene!.session.lattice;
    const raysTo = (p: Vec3): [Vec3, Vec3][] => {
      const [x, y] = viewport.project(p)!;
      return [[-1, -1], [1, 1]].map(([dx, dy]) => {
        const { origin, direction } = viewport.ray(x + dx, y + dy);
        const way = p.reduce((sum, c, i) => sum + (c - origin[i]) * direction[i], 0);
        return [origin, origin.map((c, i) => c + way * direction[i]) as unknown as Vec3];
      });
    };
    return {
      triangles: Array.from({ length: corners.length / 3 }, (_, i) => corners.slice(3 * i, 3 * i + 3) as unknown as Basis),
      rays: Array.from({ length: count }, (_, i) => raysTo([points[3 * i], points[3 * i + 1], points[3 * i + 2]])),
    };
  });
  const blocked = rays.map((each) => each.filter(([from, to]) => triangles.some((triangle) => isBetween(triangle, from, to))).length);
  const withCount = (wanted: number): number[] => blocked.flatMap((count, i) => (count === wanted ? [i] : []));
  return { hidden: withCount(2), shown: withCount(0) };
}

/** Whether the line segment from a to b passes through a triangle. */
function isBetween([p, q, r]: Basis, a: Vec3, b: Vec3): boolean {
  const edges: Basis = [sub(q, p), sub(r, p), sub(a, b)];
  const [s, t, way] = coordinates(edges, sub(a, p)); // a + way (b - a) = p + s (q - p) + t (r - p)
  return s >= 0 && t >= 0 && s + t <= 1 && way > 0 && way < 1;
}

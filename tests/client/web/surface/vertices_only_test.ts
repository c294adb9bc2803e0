// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The shape of a mesh under an ordinary lattice, and what it needs: many points in a lattice.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { evaluate } from '@src/lattice/bspline';
import { fitLattice } from '@src/lattice/fitted_lattice';
import { domain } from '@src/lattice/grid';
import type { Lattice } from '@src/lattice/lattice';
import { PlacedPoints } from '@src/lattice/placed_points';
import { distance, pointAt, type Vec3 } from '@src/lattice/vec';
import { largestDistance } from '@src/surface/largest_distance';
import { PatchPlaces } from '@src/surface/patches/patch_places';
import { TopologyLayout } from '@src/surface/topology_layout';
import { VerticesOnly } from '@src/surface/vertices_only';

const BOX = { min: [-1, 0, 2], max: [1, 1, 3] } as const;

/** A lattice around BOX whose control points are moved by sines. */
function moved(degree: Vec3): Lattice {
  const lattice = fitLattice(BOX, { size: [5, 4, 6], degree, padding: 0.05 });
  lattice.points.forEach((x, i) => (lattice.points[i] = x + 0.3 * Math.sin(7 * i + 1)));
  return lattice;
}

for (const degree of [[1, 2, 3], [3, 1, 2], [2, 3, 1]] as const) {
  test(`points in a lattice of degree ${degree.join(' x ')} move as by the definition; those outside its frame stay`, () => {
    const lattice = moved(degree);
    const rest = fitLattice(BOX, { size: [5, 4, 6], degree, padding: 0.05 });
    const { origin, u, v, w } = lattice.frame;
    const fractions: Vec3[] = [[0, 0, 0], [1, 1, 1], [0.2, 0.5, 0.9], [0.5, 0.5, 0.5], [1 / 3, 2 / 3, 0.999]];
    const inside = fractions.map(([a, b, c]): Vec3 => [origin[0] + a * u[0], origin[1] + b * v[1], origin[2] + c * w[2]]);
    const outside: Vec3[] = [[-2, 0.5, 2.5], [0, 0.5, 4]];

    const out = new PlacedPoints(rest, Float64Array.from([...inside, ...outside].flat())).deformed(lattice.points);

    fractions.forEach((at, i) => {
      const parameter = at.map((x, axis) => {
        const [begin, end] = domain(lattice, axis as 0 | 1 | 2);
        return begin + x * (end - begin);
      }) as unknown as Vec3;
      assert.ok(distance(pointAt(out, i), evaluate(lattice, parameter)) < 1e-12);
    });
    assert.deepEqual(outside, [pointAt(out, inside.length), pointAt(out, inside.length + 1)]);
  });
}

// One face of the source over two patches: corners 0 1 2, cut at the middle M of the edge from 0 to 1.
const ORIGINS = {
  corners: Uint32Array.of(0, 1, 2, 0, 1, 2),
  barycentrics: Float64Array.of(1, 0, 0, 0.5, 0.5, 0, 0, 0, 1, /**/ 0.5, 0.5, 0, 0, 1, 0, 0, 0, 1),
};
const REST = {
  origin: [0, 0, 2.5] as const,
  corners: Float32Array.of(-1, 0, 0, 0, 0, 0, 0, 1, 0, /**/ 0, 0, 0, 1, 0, 0, 0, 1, 0),
};

test('if only vertices move, patches stay in the flat triangle of their face', () => {
  const lattice = moved([2, 2, 2]);
  const at = new PlacedPoints(lattice, Float64Array.of(-1, 0, 2.5, 1, 0, 2.5, 0, 1, 2.5)).deformed(lattice.points);

  const corners = new VerticesOnly(ORIGINS, REST).corners(lattice);

  const middle = [0, 1, 2].map((axis) => (at[axis] + at[3 + axis]) / 2) as unknown as Vec3;
  const place = (i: number): Vec3 => [corners[3 * i], corners[3 * i + 1], corners[3 * i + 2] + 2.5];
  const wanted = [pointAt(at, 0), middle, pointAt(at, 2), middle, pointAt(at, 1), pointAt(at, 2)];
  wanted.forEach((point, i) => assert.ok(distance(place(i), point) < 1e-6, `${i}: ${place(i)} ${point}`));
});

test('a mesh with a vertex that no patch has cannot be compared', () => {
  const barycentrics = ORIGINS.barycentrics.map((x) => (x === 1 ? 0.9 : x));
  assert.throws(() => new VerticesOnly({ ...ORIGINS, barycentrics }, REST), /A vertex of the mesh is the corner of no patch/);
});

test('the largest distance is measured at every point, between origins far apart', () => {
  const layout = new TopologyLayout({
    topologyId: 't', segments: 2, patchCount: 1n, pointCount: 6n, chunkRuns: [{ chunkCount: 1, patchesPerChunk: 1 }],
    pattern: { points: [2, 0, 0, 1, 1, 0, 0, 2, 0, 1, 0, 1, 0, 1, 1, 0, 0, 2], triangles: [] },
  } as unknown as ConstructorParameters<typeof TopologyLayout>[0]);
  const flat = { origin: [1000, 0, 0] as const, corners: Float32Array.of(0, 0, 0, 2, 0, 0, 0, 2, 0) };
  const points = [[0, 0, 0], [1, 0, 3], [2, 0, 0], [0, 1, 0], [1, 1, -4], [0, 2, 0]];
  const numbers = points.flatMap(([x, y, z]) => [2 * x + 20, 2 * y, 2 * z, 0, 0, 0]);
  const drawn = { places: new PatchPlaces(layout), numbers, origin: [990, 0, 0] as const, step: 0.5 };

  assert.equal(largestDistance(drawn, flat, 'all points', 1), 4);
  assert.equal(largestDistance({ ...drawn, numbers: numbers.map((x, i) => (i === 12 ? x + 5 : x)) }, flat, 'corners', 1), 2.5);
});

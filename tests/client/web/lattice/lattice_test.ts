// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { evaluate, knotBoxLines } from '@src/lattice/bspline';
import { domain, indexOf, placeOf, refusalOfAxes } from '@src/lattice/grid';
import { clampedUniformKnots, grevilleAbscissae, resized } from '@src/lattice/identity';
import { gridLines, innerPoints, mirrorImage, planeOf, rowOf } from '@src/lattice/index_sets';
import { latticeFromJson, latticeToJson } from '@src/wire/lattice_json';
import { pointAt } from '@src/lattice/vec';
import { fitLattice } from '@src/lattice/fitted_lattice';

const fit = { size: [5, 4, 3], degree: [3, 2, 1], padding: 0.1 } as const;
const bounds = { min: [-1, 0, 2], max: [1, 1, 2.5] } as const;

test('clamped uniform knots and Greville abscissae are those of the definition', () => {
  assert.deepEqual([...clampedUniformKnots(2, 4)], [0, 0, 0, 1, 2, 2, 2]);
  assert.deepEqual(grevilleAbscissae([0, 0, 0, 1, 2, 2, 2], 2, 4), [0, 0.5, 1.5, 2]);
});

test('an axis that keeps its size and degree keeps its knots', () => {
  const before = fitLattice(bounds, fit);
  before.knots[1].set([0, 0, 0, 0.25, 2, 2, 2]);

  const { size, degree, knots } = resized(before, [6, 4, 3], [3, 2, 2]);

  assert.deepEqual([size, degree], [[6, 4, 3], [3, 2, 2]]);
  assert.deepEqual(knots.map((vector) => [...vector]), [[0, 0, 0, 0, 1, 2, 3, 3, 3, 3], [0, 0, 0, 0.25, 2, 2, 2], [0, 0, 0, 1, 1, 1]]);
});

test('a fit pads every axis by a fraction of the longest edge, so that flat meshes have a volume', () => {
  const { frame } = fitLattice({ min: [0, 0, 0], max: [2, 1, 0] }, { ...fit, padding: 0.25 });

  assert.deepEqual(frame.origin, [-0.5, -0.5, -0.5]);
  assert.deepEqual([frame.u, frame.v, frame.w], [[3, 0, 0], [0, 2, 0], [0, 0, 1]]);
});

test('the identity lattice leaves every point of its frame where it is', () => {
  const lattice = fitLattice(bounds, fit);
  const [ends, middle] = [domain(lattice, 0), 0.37];
  const u = ends[0] + middle * (ends[1] - ends[0]);

  const p = evaluate(lattice, [u, 1, 2]);

  const expected = [-1.2 + middle * 2.4, -0.2 + 1.4 * 0.5, 1.8 + 0.9];
  p.forEach((x, a) => assert.ok(Math.abs(x - expected[a]) < 1e-14, `axis ${a}: ${x} is not ${expected[a]}`));
});

test('the JSON comes back with the same bits, and fills in what may be missing', () => {
  const lattice = fitLattice(bounds, fit);
  lattice.points[7] = 0.1 + 0.2;

  const read = latticeFromJson(latticeToJson(lattice));

  assert.deepEqual(read, lattice);
  const { frame } = JSON.parse(latticeToJson(lattice)) as { frame: object };
  assert.equal(latticeFromJson(JSON.stringify({ frame })).count, 64);
});

for (const [what, json, words] of [
  ['no JSON', 'v 1 2 3', /^Error: The file is not the JSON of a lattice: /],
  ['an unknown field', '{"frames": {}}', /"frames" is unknown/],
  ['no frame', '{}', /no "frame"/],
  ['a size that the degree forbids', '{"size": {"u": 2, "v": 4, "w": 4}}', /at least 3 control points/],
  ['too few numbers', '{"frame": {}, "controlPoints": [1, 2]}', /has 2 numbers; .* need 192/],
  ['a number that is none', '{"frame": {"u": {"x": "wide"}}}', /not the JSON of a lattice/],
  ['knots that fall', '{"frame": {}, "knotsU": [0, 0, 0, 2, 1, 2, 2]}', /must not decrease/],
] as const) {
  test(`a lattice file with ${what} is refused in words`, () => assert.throws(() => latticeFromJson(json), words));
}

test('rows, planes, inner points and images of a 5 x 4 x 3 grid', () => {
  const size = [5, 4, 3] as const;
  const index = indexOf(size, [1, 2, 0]);

  assert.deepEqual(placeOf(size, index), [1, 2, 0]);
  assert.deepEqual(rowOf(size, index, 2), [11, 31, 51]);
  assert.deepEqual(planeOf(size, index, 0), [1, 6, 11, 16, 21, 26, 31, 36, 41, 46, 51, 56]);
  assert.deepEqual(innerPoints(size), [26, 27, 28, 31, 32, 33]);
  assert.equal(mirrorImage(size, index, [0, 2]), indexOf(size, [3, 2, 2]));
});

test('grid lines join neighbours and leave out hidden points', () => {
  const size = [2, 2, 2] as const;

  assert.equal(gridLines(size, () => false).length, 2 * 12);
  assert.equal(gridLines(size, (i) => i === 0).length, 2 * 9);
});

test('knot box edges pass through the corners of the frame', () => {
  const lattice = fitLattice(bounds, { ...fit, size: [4, 3, 2], degree: [2, 2, 1] });

  const lines = knotBoxLines(lattice, 2);

  // There are 3, 2 and 2 knot planes along u, v and w, so 2 x 4, 1 x 6 and 1 x 6 edges along them, of two lines each.
  assert.equal(lines.length, 6 * 2 * (8 + 6 + 6));
  assert.deepEqual(pointAt(lines, 0).map((x) => Number(x.toFixed(12))), [-1.2, -0.2, 1.8]);
});

test('sizes and degrees out of range are refused in words', () => {
  assert.equal(refusalOfAxes([32, 32, 32], [3, 3, 3]), undefined);
  assert.match(refusalOfAxes([33, 32, 32], [2, 2, 2]) ?? '', /33,792 control points are too many: at most 32,768/);
  assert.match(refusalOfAxes([4, 4, 4], [4, 2, 2]) ?? '', /degree along u is 1, 2 or 3/);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices that go on outside their frame, against formula (1) of the given lattice.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { SceneSchema, SceneService, type CreateSceneRequest } from 'latticed/v1/scene_pb';
import { boxCorners } from '@src/cage/outside_box';
import { Services } from '@src/intake/services';
import { evaluate } from '@src/lattice/bspline';
import { fitLattice } from '@src/lattice/fitted_lattice';
import { domain, indexOf, sameStructure } from '@src/lattice/grid';
import { identityPoints } from '@src/lattice/identity';
import { Lattice, type Outside, type Vec3 } from '@src/lattice/lattice';
import { boxGrid, pointsOfBox } from '@src/lattice/box_grid';
import { LatticeRemarks } from '@src/lattice/lattice_remarks';
import { allowedWidth, continuedLattice, effectiveLattice, OutsideMap } from '@src/lattice/outside';
import { carriedBy, isAtRest } from '@src/lattice/parent';
import type { Folds } from '@src/wire/fold_message';
import { toOutside } from '@src/wire/lattice_message';
import { LatticedServer } from '@src/wire/latticed_server';
import { latticeFromJson, latticeToJson } from '@src/wire/lattice_json';

const SIX = [0, 1, 2, 3, 4, 5] as const;
const falloff = (smooth: boolean): Outside => ({ mode: 'falloff', smooth, widths: SIX.map(() => 0.3), steps: [] });
const linear: Outside = { mode: 'linear', smooth: true, widths: SIX.map(() => 2), steps: [] };

function latticeOf(degree: Vec3, outside: Outside | undefined, move: (p: Vec3) => Vec3): Lattice {
  const size = degree.map((n, axis) => n + 1 + axis) as unknown as Vec3;
  const fit = fitLattice({ min: [-1, 0, 2], max: [1, 1, 2.5] }, { size, degree, padding: 0.1 });
  const points = fit.points.slice();
  for (let at = 0; at < points.length; at += 3) points.set(move([points[at]!, points[at + 1]!, points[at + 2]!]), at);
  return new Lattice(fit.frame, degree, size, fit.knots, points, outside);
}

const wave = ([x, y, z]: Vec3): Vec3 => [x + 0.3 * Math.sin(5 * y), y + 0.2 * Math.cos(4 * z), z + 0.25 * x * x];

/** A place in the frame, 0 to 1 inside. */
function at(lattice: Lattice, place: Vec3): Vec3 {
  const map = new OutsideMap(lattice);
  const { frame, degree, size, knots } = map.continued;
  const whole = new Lattice(frame, degree, size, knots, map.points(lattice.points));
  return evaluate(whole, place.map((p, axis) => {
    const [begin, end] = domain(lattice, axis as 0 | 1 | 2);
    return begin + p * (end - begin);
  }) as unknown as Vec3);
}

const rounded = (x: number): number => Math.round(x * 1e12) / 1e12 + 0; // no -0
const distance = (a: Vec3, b: Vec3): number => Math.hypot(...a.map((x, i) => x - b[i]!));

for (const degree of [[1, 2, 3], [2, 3, 1], [3, 1, 2], [2, 2, 2]] as const) {
  for (const outside of [falloff(true), falloff(false), linear]) {
    test(`degree ${degree}, ${outside.mode}, smooth ${outside.smooth}: the inside stays, and no face has a gap`, () => {
      const lattice = latticeOf(degree, outside, wave);
      for (const place of [[0.1, 0.5, 0.9], [0.999, 0.001, 0.3], [0, 1, 0.4]] as const) {
        const inside = evaluate(lattice, place.map((p, a) => p * domain(lattice, a as 0 | 1 | 2)[1]) as unknown as Vec3);
        assert.ok(distance(at(lattice, place), inside) < 1e-13);
      }
      assert.ok(distance(at(lattice, [1 - 1e-9, 0.4, 0.6]), at(lattice, [1 + 1e-9, 0.4, 0.6])) < 1e-7);
      assert.ok(distance(at(lattice, [0.2, -1e-9, 0.6]), at(lattice, [0.2, 1e-9, 0.6])) < 1e-7);
    });
  }
}

test('a falloff ends at rest, and an affine map goes on linearly', () => {
  const ended = latticeOf([2, 3, 1], falloff(true), wave);
  const { origin, u, v, w } = ended.frame;
  const rest = (place: Vec3): Vec3 => origin.map((x, c) => x + place[0] * u[c]! + place[1] * v[c]! + place[2] * w[c]!) as unknown as Vec3;
  assert.ok(distance(at(ended, [1.3, 0.4, 0.6]), rest([1.3, 0.4, 0.6])) < 1e-13);
  assert.ok(distance(at(ended, [1.15, 0.4, 0.6]), rest([1.15, 0.4, 0.6])) > 1e-2);

  const shear = ([x, y, z]: Vec3): Vec3 => [x + 0.5 * y, y - 0.2 * z, 1.5 * z + 1];
  const sheared = latticeOf([3, 2, 1], linear, shear);
  assert.ok(distance(at(sheared, [2.5, -1, 1.7]), shear(rest([2.5, -1, 1.7]))) < 1e-12);
});

test('points at rest keep their bits, and a moved one reaches those that depend on it', () => {
  const lattice = latticeOf([2, 2, 2], { ...falloff(true), widths: [0, 0.3, 0, 0, 0, 0] }, (p) => p);
  const map = new OutsideMap(lattice);
  const rest = identityPoints(map.continued);
  assert.deepEqual(map.points(lattice.points), rest);
  const moved = indexOf(lattice.size, [2, 1, 1]);
  lattice.points[3 * moved]! += 0.1;
  const points = map.points(lattice.points);
  const changed = Array.from({ length: rest.length / 3 }, (_, i) => i).filter((i) => points[3 * i] !== rest[3 * i]);
  assert.deepEqual(changed, [...map.reached([moved])]);
  assert.ok(changed.length > 0);
  assert.ok(map.sources(changed).includes(moved));
  assert.deepEqual(map.sources([0]), [0]); // nothing goes on at this corner
});

test('the folded boxes that the server names are those of the continued lattice', () => {
  const lattice = latticeOf([2, 2, 2], { ...falloff(true), widths: [0.3, 0, 0, 0, 0, 0] }, wave);
  const { edges } = boxGrid(continuedLattice(lattice), [2, 0, 0], 1); // two boxes are in front of the lattice's first one
  assert.deepEqual(edges.map((p) => p.map((x) => x.toFixed(9))), boxGrid(lattice, [0, 0, 0], 1).edges.map((p) => p.map((x) => x.toFixed(9))));
  const remarks = new LatticeRemarks(lattice, undefined).of(lattice, { places: [[2, 0, 0]] } as unknown as Folds);
  assert.deepEqual(remarks[0]!.points, pointsOfBox(lattice, [0, 0, 0]));
});

test('nothing goes on without widths', () => {
  const lattice = latticeOf([2, 2, 2], { ...falloff(true), widths: SIX.map(() => 0) }, wave);
  const map = new OutsideMap(lattice);
  assert.equal(map.continued, lattice);
  assert.equal(map.points(lattice.points), lattice.points);
  assert.deepEqual(map.reached([3]), [3]);
});

test('a width that is wanted becomes 0 or one that the server takes', () => {
  assert.deepEqual([-1, 0, 0.0009, 0.001, 0.3, 1000, 2000].map(allowedWidth), [0, 0, 0, 0.001, 0.3, 1000, 1000]);
});

test('the box that shows where it ends reaches beyond the frame by each width', () => {
  const frame = { origin: [1, 0, 0], u: [2, 0, 0], v: [0, 4, 0], w: [0, 0, 8] } as const;
  const corners = boxCorners(frame, [0.5, 0, 0.25, 0.5, 1, 2]);
  assert.deepEqual(corners[0], [0, -1, -8]);
  assert.deepEqual(corners[1], [3, -1, -8]);
  assert.deepEqual(corners[7], [3, 6, 24]);
});

test('a fitted lattice has it', () => {
  const bounds = { min: [0, 0, 0], max: [1, 1, 1] } as const;
  const fit = { size: [3, 3, 3], degree: [2, 2, 2], padding: 0 } as const;
  assert.deepEqual(fitLattice(bounds, { ...fit, outside: falloff(false) }).outside, falloff(false));
  assert.equal(fitLattice(bounds, fit).outside, undefined);
});

test('the server is asked for a fitted lattice with it', async () => {
  const asked: CreateSceneRequest[] = [];
  const server = new LatticedServer('http://test', undefined, createRouterTransport(({ service }) =>
    service(SceneService, { createScene: (request) => (asked.push(request), create(SceneSchema, {})) })));
  const fit = { size: [3, 3, 3], degree: [2, 2, 2], padding: 0 } as const;
  for (const outside of [undefined, falloff(false), falloff(true), linear]) {
    await new Services(server).createScene('m', { lattice: { ...fit, outside }, view: {} });
    const { source } = asked.at(-1)!.lattices[0]!;
    assert.ok(source.case === 'fit');
    assert.deepEqual(toOutside(source.value.outside), outside);
  }
});

test('files keep it, and it is part of the structure', () => {
  const lattice = latticeOf([2, 3, 1], falloff(false), wave);
  const read = latticeFromJson(latticeToJson(lattice));
  assert.deepEqual(read.outside, lattice.outside);
  assert.ok(sameStructure(read, lattice));
  assert.ok(!sameStructure(read, new Lattice(read.frame, read.degree, read.size, read.knots, read.points)));
});

test('points go that part of their way that the strength says, with and without a continuation', () => {
  for (const outside of [undefined, falloff(true)]) {
    const lattice = latticeOf([2, 3, 1], outside, wave);
    const map = new OutsideMap(lattice);
    const rest = map.points(identityPoints(lattice)), whole = map.points(lattice.points);
    const part = map.points(lattice.points, 0.25);
    part.forEach((x, i) => assert.ok(Math.abs(x - (rest[i]! + 0.25 * (whole[i]! - rest[i]!))) < 1e-14));
    assert.deepEqual(map.points(lattice.points, 0), rest);
    lattice.strength = 0.25;
    assert.deepEqual(continuedLattice(lattice).points, part);
    assert.deepEqual(continuedLattice(effectiveLattice(lattice)).points.map(rounded), part.map(rounded));
  }
});

test('a parent carries points in its frame and in what goes on outside of it, and moves nothing at rest', () => {
  const points = Float64Array.from([-0.999, 0, 2, -1.2, 0.5, 2.25, -1.8, 0.5, 2.25, 1.2 + 1e-12, 0.5, 2.25]); // the frame begins and ends at x = -1.2 and 1.2
  const parent = latticeOf([2, 2, 2], undefined, wave);
  assert.deepEqual(carriedBy(parent, points, [0, 1, 2, 3]), [0, 1, 3]);
  assert.deepEqual(carriedBy(parent, points, [2, 3]), [3]);
  assert.deepEqual(carriedBy(latticeOf([2, 2, 2], falloff(true), wave), points, [0, 1, 2, 3]), [0, 1, 2, 3]);
  assert.ok(!isAtRest(parent));
  assert.ok(isAtRest(latticeOf([2, 2, 2], undefined, (p) => p)));
  parent.strength = 0;
  assert.ok(isAtRest(parent));
});

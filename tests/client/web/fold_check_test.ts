// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { fitLattice } from '@src/lattice/fitted_lattice';
import { FoldCheck, type Fractions } from '@src/lattice/fold_check';
import { latticeFromJson } from '@src/wire/lattice_json';

const ALL: Fractions = [[0, 1], [0, 1], [0, 1]];
const bounds = { min: [-1, -1, -1], max: [1, 1, 1] } as const;
const cube = () => fitLattice(bounds, { size: [5, 4, 4], degree: [3, 2, 1], padding: 0 });

test('a lattice folds over where control points pass one another, and the points that cover the place are found', () => {
  const lattice = cube();
  const check = new FoldCheck(lattice, ALL);
  assert.equal(check.folded(lattice.points), undefined);

  lattice.points[0] += 0.3; // the corner at u = v = w = 0 moves inwards a little
  assert.equal(check.folded(lattice.points), undefined);
  lattice.points[0] += 2;
  const found = check.folded(lattice.points)!;
  assert.equal(found.length, 4 * 3 * 2);
  assert.ok(found.includes(0));
  assert.ok(found.every((index) => index % 5 < 4 && index < 40), `${found}`); // u, v and w from 0

  assert.equal(new FoldCheck(lattice, [[0.5, 1], [0.5, 1], [0.5, 1]]).folded(lattice.points), undefined); // the mesh is elsewhere
});

test('a mirrored, a flattened and a turned lattice, a flat mesh, and a frame of the other handedness', () => {
  const lattice = cube();
  const sheet: Fractions = [[0, 1], [0, 1], [0.5, 0.5]];
  const mapped = (of: (x: number, y: number, z: number) => readonly number[]): Float64Array =>
    lattice.points.map((_, i, all) => of(all[i - (i % 3)], all[i - (i % 3) + 1], all[i - (i % 3) + 2])[i % 3]);
  for (const within of [ALL, sheet]) {
    const check = new FoldCheck(lattice, within);
    assert.ok(check.folded(mapped((x, y, z) => [-x, y, z])));
    assert.ok(check.folded(mapped((x, y) => [x, y, 0])));
    assert.equal(check.folded(mapped((x, y, z) => [-y, x, 2 * z])), undefined);
  }
  const { frame } = lattice;
  const mirrored = { ...lattice, frame: { ...frame, origin: [1, -1, -1], u: [-2, 0, 0] }, size: lattice.size } as const;
  assert.equal(new FoldCheck(mirrored, ALL).folded(mapped((x, y, z) => [-x, y, z])), undefined);
});

test('the beam of the start page, twisted and bent, does not fold over; nor does a full lattice at rest', () => {
  const beam = latticeFromJson(readFileSync('samples/beam_lattice.json', 'utf8'));
  assert.equal(new FoldCheck(beam, ALL).folded(beam.points), undefined);

  const full = fitLattice(bounds, { size: [32, 32, 32], degree: [3, 3, 3], padding: 0 });
  assert.equal(new FoldCheck(full, ALL).folded(full.points), undefined);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node evaluate_patches_test.mjs EXAMPLE: the built client/node
// A lattice that goes on outside its frame is refused: patches are of the continued lattice, which the example does not make.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';

const { evaluatePatches } = await import(pathToFileURL(join(process.argv[2], 'dist', 'evaluate_patches.js')));

const NUMBER = 8; // control points of degree 1 at the corners of the unit cube
const axes = (n) => ({ u: n, v: n, w: n });
const knots = [0, 0, 1, 1];
const lattice = {
  degree: axes(1), size: axes(2), knotsU: knots, knotsV: knots, knotsW: knots,
  controlPoints: Array.from({ length: NUMBER }, (_, i) => [i & 1, (i >> 1) & 1, i >> 2]).flat(),
};
const plan = { // one flat patch
  patches: 1, edgeCount: 3, edges: [0, 1, 2], corners: [0, 1, 2], places: [[0, 0, 0], [65535, 0, 0], [0, 65535, 0]], levelOf: () => 0,
};
const evaluate = (outside) => evaluatePatches(plan, { ...lattice, outside }, new Uint8Array(3), 0.1);

test('a lattice that ends at its frame is evaluated', () => {
  const expected = { points: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [0, 1, 2] };
  for (const outside of [undefined, null, { mode: 'OUTSIDE_MODE_UNSPECIFIED' }, { mode: 'OUTSIDE_MODE_FIXED' }]) {
    assert.deepEqual(evaluate(outside), expected);
  }
});

test('a lattice that goes on outside is refused', () => {
  for (const mode of ['OUTSIDE_MODE_FALLOFF', 'OUTSIDE_MODE_LINEAR']) {
    assert.throws(() => evaluate({ mode, widths: [1] }), /has no lattices that go on outside their frame/);
  }
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node effective_points_test.mjs EXAMPLE: the built client/node
// The control points of a scene at a strength: on the way from the Greville points.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';

const [example] = process.argv.slice(2);
const { effectivePoints } = await import(pathToFileURL(join(example, 'dist', 'effective_points.js')));

// Degree 2 with the knots 0 0 0 1 2 2 2 on u: Greville points at 0, 1/4, 3/4 and 1 of the edge. Degree 1 on v and w.
const frame = {
  origin: { x: 1, y: 0, z: 0 }, u: { x: 4, y: 0, z: 0 }, v: { x: 0, y: 2, z: 0 }, w: { x: 0, y: 0, z: 3 },
};
const rest = [0, 3].flatMap((z) => [0, 2].flatMap((y) => [1, 2, 4, 5].flatMap((x) => [x, y, z])));
const lattice = {
  frame, degree: { u: 2, v: 1, w: 1 }, size: { u: 4, v: 2, w: 2 },
  knotsU: [0, 0, 0, 1, 2, 2, 2], knotsV: [0, 0, 1, 1], knotsW: [0, 0, 1, 1],
  controlPoints: rest.map((x, i) => x + 0.5 * (i % 5)),
};

test('half of the way at one half, none at 0, and all of it where no strength is told', () => {
  assert.deepEqual(effectivePoints({ lattice, strength: 0.5 }), rest.map((x, i) => x + 0.25 * (i % 5)));
  assert.deepEqual(effectivePoints({ lattice, strength: 0 }), rest);
  assert.deepEqual(effectivePoints({ lattice }), lattice.controlPoints);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What edits keep: which control points are held, messages and back, and what is sent and told.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { heldPoints, NO_CONSTRAINTS, withLayers, type Constraints } from '@src/lattice/constraints';
import { volumeInWords } from '@src/state/units';
import { fromConstraints, toConstraints } from '@src/wire/constraint_message';
import { SessionFixture } from '../support/session_fixture';

test('points are held by index, by layers, and with their mirror images', () => {
  assert.deepEqual([...heldPoints([4, 4, 4], NO_CONSTRAINTS)], []);
  assert.deepEqual([...heldPoints([4, 4, 4], { ...NO_CONSTRAINTS, held: [5] })], [5]);
  assert.deepEqual([...heldPoints([4, 4, 4], { ...NO_CONSTRAINTS, held: [5], mirror: 0 })], [5, 6]);
  const layers = [{ axis: 2, atEnd: true, layers: 2 }] as const;
  const held = heldPoints([4, 4, 4], { held: [], layers });
  assert.deepEqual([...held], Array.from({ length: 32 }, (_, i) => 32 + i));
  assert.equal(heldPoints([4, 4, 4], withLayers(NO_CONSTRAINTS, 1)).size, 64 - 8);
  assert.deepEqual(withLayers(withLayers(NO_CONSTRAINTS, 1), 0).layers, []);
});

test('constraints survive as messages', () => {
  const all: Constraints = {
    held: [1, 7], layers: [{ axis: 1, atEnd: true, layers: 3 }], mirror: 2, volume: { volume: 2.5, axis: 0 },
  };
  assert.deepEqual(toConstraints(fromConstraints(all)), all);
  const rest = toConstraints(fromConstraints({ ...NO_CONSTRAINTS, volume: {} }));
  assert.deepEqual(rest.volume, { volume: undefined, axis: undefined });
  assert.equal(toConstraints(fromConstraints(NO_CONSTRAINTS)).mirror, undefined);
});

test('a session sends constraints as one edit', async (t) => {
  const fixture = await SessionFixture.live(t);
  assert.equal(fixture.session.held.size, 0);

  fixture.session.constrain({ held: [3], layers: [], volume: {} });

  const [batch] = fixture.stream.edits;
  const { edit } = batch.edits[0];
  assert.ok(edit.case === 'setConstraints');
  assert.deepEqual(edit.value.constraints?.held, [3]);
  assert.ok(edit.value.constraints?.volume !== undefined);
});

test('volumes are told in the unit that suits them', () => {
  assert.equal(volumeInWords(6, { metersPerUnit: 0 }), '6 cubic units');
  assert.equal(volumeInWords(2e-6, { metersPerUnit: 1 }), '2 cm³');
  assert.equal(volumeInWords(-8, { metersPerUnit: 1 }), '-8 m³');
});

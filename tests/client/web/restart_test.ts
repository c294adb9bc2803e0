// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene that somebody made again under the same id, on a server that kept nothing. Its history begins anew.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import type { LatticeEdit } from '@src/session/edits/lattice_edit';
import { SessionFixture, cubeLattice } from './support/session_fixture';
import { fitLattice } from '@src/lattice/fitted_lattice';

const OTHER_STRUCTURE = fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [4, 3, 3], degree: [2, 2, 2], padding: 0 });

const move = (x: number): LatticeEdit => ({ kind: 'move', indices: Uint32Array.of(1), offset: [x, 0, 0] });

/** A window at revision 7, whose last edit is answered but not yet in its lattice. Then the scene is made again. */
async function madeAgain(t: TestContext): Promise<SessionFixture> {
  const fixture = await SessionFixture.live(t);
  fixture.state(cubeLattice(), 1n, 7n);
  fixture.session.apply(move(0.25));
  fixture.accept(1n, 8n);
  await fixture.reconnect();
  return fixture;
}

test('what was answered before is neither shown nor undone', async (t) => {
  const fixture = await madeAgain(t);
  assert.equal(fixture.x(1), 0.75);
  assert.ok(fixture.session.canUndo);

  fixture.state();

  assert.equal(fixture.x(1), 0.5);
  assert.ok(!fixture.session.canUndo);
  assert.ok(fixture.session.isAt(0));
});

test('edits that were made meanwhile are sent, in their order', async (t) => {
  const fixture = await madeAgain(t);
  fixture.session.apply(move(0.125));
  fixture.session.apply(move(0.0625));
  fixture.state();
  fixture.accept(2n, 1n);
  fixture.accept(3n, 2n);

  assert.deepEqual(fixture.stream.edits.map(({ sequence }) => sequence), [2n, 3n]);
  assert.deepEqual(fixture.said, []);
});

test('edits for a lattice with other control points are dropped, in words', async (t) => {
  const fixture = await madeAgain(t);
  fixture.session.apply(move(0.125)); // in flight
  fixture.session.apply(move(0.0625));

  fixture.state(OTHER_STRUCTURE, 2n);

  assert.match(fixture.said.join(), /other control points meanwhile, so unsent edits were dropped/);
  assert.deepEqual(fixture.session.lattice.size, [4, 3, 3]);
});

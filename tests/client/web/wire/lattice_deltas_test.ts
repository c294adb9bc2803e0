// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Deltas that contradict the lattice that they are of.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { fromLattice } from '@src/wire/lattice_message';
import { cubeLattice, SessionFixture, until } from '../support/session_fixture';

const WRONG = [
  { indices: [1, 2], positions: [7, 7, 7], text: /\(a lattice_delta must have three numbers per index\)/ },
  { indices: [1], positions: [7, 7, 7, 7], text: /\(a lattice_delta must have three numbers per index\)/ },
  { indices: [1, 27], positions: [7, 7, 7, 7, 7, 7], text: /\(a lattice_delta names a control point that does not exist\)/ },
];

/** Two lattices, of which the first is shown. */
async function live(t: TestContext): Promise<SessionFixture> {
  const fixture = await SessionFixture.live(t);
  fixture.stream.event({ case: 'latticeState', value: { lattice: fromLattice(cubeLattice()), structureId: 1n, revision: 0n, index: 1 } });
  return fixture;
}

for (const lattice of [0, 1]) {
  for (const { indices, positions, text } of WRONG) {
    test(`${indices.length} indices with ${positions.length} numbers move nothing of lattice ${lattice}, and all is asked for anew`, async (t) => {
      const fixture = await live(t);
      const { session, sockets } = fixture;
      const strength = 0.5;

      fixture.stream.event({ case: 'latticeDelta', value: { structureId: 1n, revision: 1n, lattice, indices, positions, strength } });

      assert.equal(session.status.state, 'retrying');
      assert.match(session.status.text, text);
      assert.deepEqual(session.lattices.map(({ points }) => [...points]), [0, 1].map(() => [...cubeLattice().points]));
      assert.deepEqual([...session.lattice.points], [...cubeLattice().points]);
      assert.equal(session.lattice.strength, 1);
      assert.ok(session.isAt(0), 'the lattice is of the revision before');
      await until(() => sockets.opened.length === 2);
      assert.deepEqual([...sockets.newest.request.resumeToken!], []);
    });
  }
}

test('a delta of another structure is passed over: a state follows', async (t) => {
  const fixture = await live(t);
  const { indices, positions } = WRONG[0]!;
  fixture.stream.event({ case: 'latticeDelta', value: { structureId: 2n, revision: 1n, indices, positions } });
  assert.equal(fixture.session.status.state, 'live');
  assert.equal(fixture.x(1), 0.5);
});

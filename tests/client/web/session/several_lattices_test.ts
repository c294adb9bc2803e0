// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of several lattices: one is shown and edited at a time.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { fromLattice } from '@src/wire/lattice_message';
import { delta, move } from '../support/lattice_events';
import { cubeLattice, SessionFixture } from '../support/session_fixture';

/** Two lattices; x of control point 1 is 0.5 in the first, and 0.625 in the second. */
async function live(t: TestContext): Promise<SessionFixture> {
  const fixture = await SessionFixture.live(t);
  const second = cubeLattice();
  second.points[3] = 0.625;
  fixture.stream.event({ case: 'latticeState', value: { lattice: fromLattice(second), structureId: 1n, revision: 0n, index: 1 } });
  return fixture;
}

test('the first is shown until another is chosen, which has followed its own edits meanwhile', async (t) => {
  const fixture = await live(t);
  const { session } = fixture;
  assert.equal(session.latticeCount, 2);
  assert.equal(fixture.x(1), 0.5);
  delta(fixture, 1, 1n, 0.875);
  assert.equal(fixture.x(1), 0.5);
  assert.ok(session.isAt(1));
  let shown = 0;
  session.on('lattice', () => ++shown);

  session.chooseLattice(1);

  assert.equal(shown, 1);
  assert.equal(fixture.x(1), 0.875);
  delta(fixture, 0, 2n, 0.25);
  assert.equal(fixture.x(1), 0.875);
  session.chooseLattice(0);
  assert.equal(fixture.x(1), 0.25);
});

test('edits and undo steps are of the chosen one, and weights of the first', async (t) => {
  const fixture = await live(t);
  const { session, stream } = fixture;
  session.chooseLattice(1);
  session.apply(move(0.125));
  assert.equal(stream.edits[0]!.lattice, 1);
  fixture.accept(stream.edits[0]!.sequence, 1n);
  delta(fixture, 1, 1n, 0.75);
  assert.ok(session.canUndo);

  session.chooseLattice(0);
  assert.ok(!session.canUndo);
  session.chooseLattice(1);
  assert.ok(session.canUndo);
  session.setWeights([0], Float32Array.of(0.5));
  assert.equal(stream.edits[1]!.lattice, 0);
});

test('a lattice that is added is shown when the server has it, with its undo step', async (t) => {
  const fixture = await live(t);
  const { session, stream } = fixture;
  const third = cubeLattice();
  third.points[3] = 0.375;

  session.addLattice(third);

  const batch = stream.edits[0]!;
  assert.equal(batch.lattice, 2);
  assert.equal(batch.edits[0]!.edit.case, 'replaceLattice');
  fixture.stream.event({ case: 'editResult', value: { sequence: batch.sequence, revision: 1n, structureId: 2n } });
  [cubeLattice(), cubeLattice(), third].forEach((lattice, index) => {
    fixture.stream.event({ case: 'latticeState', value: { lattice: fromLattice(lattice), structureId: 2n, revision: 1n, index } });
  });
  assert.equal(session.latticeIndex, 2);
  assert.equal(session.latticeCount, 3);
  assert.equal(fixture.x(1), 0.375);
  assert.ok(session.canUndo);
  session.chooseLattice(0);
  assert.ok(!session.canUndo);
});

test('a lattice that is chosen while an edit waits is shown when all states have come', async (t) => {
  const fixture = await live(t);
  const { session, stream } = fixture;
  session.chooseLattice(1);
  session.insertKnot(0, 0.5);
  session.chooseLattice(0);
  assert.equal(session.shownLatticeIndex, 1);
  const other = cubeLattice();
  other.points[3] = 0.25;
  stream.event({ case: 'editResult', value: { sequence: stream.edits[0]!.sequence, revision: 1n, structureId: 2n } });
  [other, cubeLattice()].forEach((lattice, index) => {
    stream.event({ case: 'latticeState', value: { lattice: fromLattice(lattice), structureId: 2n, revision: 1n, index } });
  });
  assert.equal(session.shownLatticeIndex, 0);
  assert.equal(fixture.x(1), 0.25);
});

test('a lattice that is refused leaves the one that is shown', async (t) => {
  const fixture = await live(t);
  const { session, stream } = fixture;
  session.addLattice(cubeLattice());
  const status = { code: 3, message: 'lattices[2].outside: the lattice ends inside the mesh' };
  stream.event({ case: 'editResult', value: { sequence: stream.edits[0]!.sequence, revision: 0n, structureId: 1n, status } });
  assert.equal(session.latticeIndex, 0);
  assert.equal(session.latticeCount, 2);
  session.apply(move(0.25));
  assert.equal(stream.edits[1]!.lattice, 0);
});

test('a choice waits for the answers of edits', async (t) => {
  const fixture = await live(t);
  const { session, stream } = fixture;
  session.apply(move(0.25));

  session.chooseLattice(1);

  assert.equal(session.latticeIndex, 1);
  assert.equal(fixture.x(1), 0.75, 'the first is still shown');
  fixture.accept(stream.edits[0]!.sequence, 1n);
  delta(fixture, 0, 1n, 0.75);
  assert.equal(fixture.x(1), 0.625);
});

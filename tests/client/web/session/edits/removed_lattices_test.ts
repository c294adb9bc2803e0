// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of several lattices, some of which are removed and given back, by this window and by others.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import { fitLattice } from '@src/lattice/fitted_lattice';
import { fromLattice } from '@src/wire/lattice_message';
import { refusal } from '../../support/fake_stream';
import { accepted, delta, move, states } from '../../support/lattice_events';
import { cubeLattice, SessionFixture, until } from '../../support/session_fixture';

test('a scene opens whose lattice 0 was removed before: its first lattice is shown', async (t) => {
  const fixture = new SessionFixture(t);
  const { session, stream } = fixture;
  let shown = 0;
  session.on('lattice', () => ++shown);
  stream.hello();
  states(fixture, [1, 3], 4n, 5n);
  await session.ready;
  assert.equal(shown, 1);
  assert.equal(session.shownLatticeIndex, 1);
  assert.equal(session.latticeIndex, 1);
  assert.equal(fixture.x(1), 3);
  session.apply(move(0.5));
  assert.equal(stream.edits[0]!.lattice, 1);
  session.chooseLattice(3);
  assert.equal(session.latticeIndex, 3);
});

for (const first of ['answer', 'states']) {
  test(`a removed lattice gives way to the first that is left, and undo shows it again: first the ${first}`, async (t) => {
    const fixture = await SessionFixture.live(t);
    const { session, stream } = fixture;
    states(fixture, [0, 1, 2], 1n, 2n);
    const follow = (numbers: number[], revision: bigint): void => {
      if (first === 'answer') accepted(fixture, revision, revision + 1n);
      states(fixture, numbers, revision, revision + 1n);
      if (first === 'states') accepted(fixture, revision, revision + 1n);
    };
    session.chooseLattice(1);
    assert.equal(fixture.x(1), 3);

    session.removeLattice();

    assert.equal(stream.edits[0]!.lattice, 1);
    assert.equal(stream.edits[0]!.edits[0]!.edit.case, 'removeLattice');
    follow([0, 2], 2n);
    assert.deepEqual(session.latticeNumbers, [0, 2]);
    assert.equal(session.latticeIndex, 0);
    assert.equal(session.shownLatticeIndex, 0);
    assert.equal(fixture.x(1), 2);
    assert.ok(session.isAt(2));
    assert.ok(session.canUndo);
    session.undo();
    assert.equal(stream.edits[1]!.lattice, 1);
    follow([0, 1, 2], 3n);
    assert.equal(session.shownLatticeIndex, 1);
    assert.equal(fixture.x(1), 3);
    assert.ok(session.canRedo);
    session.redo();
    assert.equal(stream.edits[2]!.lattice, 1);
    follow([0, 2], 4n);
    assert.equal(session.shownLatticeIndex, 0);
    session.undo();
    assert.equal(stream.edits[3]!.lattice, 1);
  });
}

for (const first of ['answer', 'states']) {
  test(`redo gives a lattice back whose addition was undone, until another step: first the ${first}`, async (t) => {
    const fixture = await SessionFixture.live(t);
    const { session, stream } = fixture;
    states(fixture, [0], 1n, 2n);
    const follow = (numbers: number[], revision: bigint): void => {
      if (first === 'answer') accepted(fixture, revision, revision + 1n);
      states(fixture, numbers, revision, revision + 1n);
      if (first === 'states') accepted(fixture, revision, revision + 1n);
    };
    session.addLattice(cubeLattice());
    follow([0, 1], 2n);
    session.undo();
    assert.equal(stream.edits[1]!.lattice, 1);
    follow([0], 3n);
    assert.equal(session.shownLatticeIndex, 0);
    assert.ok(!session.canUndo);
    assert.ok(session.canRedo);
    session.redo();
    assert.equal(stream.edits[2]!.lattice, 1);
    assert.equal(stream.edits[2]!.edits[0]!.edit.case, 'redo');
    follow([0, 1], 4n);
    assert.equal(session.shownLatticeIndex, 1);
    session.undo();
    follow([0], 5n);
    session.apply(move(0.5));
    fixture.accept(stream.edits[4]!.sequence, 6n);
    assert.ok(!session.canRedo);
  });
}

test('undo takes back later steps first, and the removal of lattice 0 by its number', async (t) => {
  const fixture = await SessionFixture.live(t);
  const { session, stream } = fixture;
  states(fixture, [0, 1], 1n, 2n);
  session.removeLattice();
  accepted(fixture, 2n, 3n);
  states(fixture, [1], 2n, 3n);
  session.apply(move(0.5));
  fixture.accept(stream.edits[1]!.sequence, 3n);
  delta(fixture, 1, 3n, 3.5);
  assert.equal(stream.edits[1]!.lattice, 1);

  session.undo();
  assert.equal(stream.edits[2]!.lattice, 1);
  accepted(fixture, 4n, 3n);
  session.undo();

  assert.equal(stream.edits[3]!.lattice, 0);
  assert.equal(stream.edits[3]!.edits[0]!.edit.case, 'undo');
});

for (const first of ['answer', 'states']) {
  test(`weights that are set after lattice 0 was removed are undone before its removal, and made again: first the ${first}`, async (t) => {
    const fixture = await SessionFixture.live(t);
    const { session, stream } = fixture;
    const sent = (): unknown[] => [stream.edits.at(-1)!.lattice, stream.edits.at(-1)!.edits[0]!.edit.case];
    const follow = (numbers: number[], revision: bigint): void => {
      if (first === 'answer') accepted(fixture, revision, revision);
      states(fixture, numbers, revision, revision);
      if (first === 'states') accepted(fixture, revision, revision);
    };
    states(fixture, [0, 1], 1n, 1n);
    session.removeLattice();
    follow([1], 2n);
    session.apply(move(0.5));
    follow([1], 3n);
    session.setWeights([0], Float32Array.of(0.5));
    assert.deepEqual(sent(), [0, 'setWeights']);
    follow([1], 4n);
    assert.ok(session.canUndo);

    session.undo();
    assert.deepEqual(sent(), [0, 'undo']);
    follow([1], 5n);
    assert.equal(session.latticeIndex, 1, 'lattice 0 is still away');
    assert.ok(session.canRedo);
    session.redo();
    assert.deepEqual(sent(), [0, 'redo']);
    follow([1], 6n);
    session.undo();
    follow([1], 7n);
    session.undo();
    assert.deepEqual(sent(), [0, 'undo']);
    follow([0, 1], 8n);
    assert.equal(session.latticeIndex, 0);
    assert.equal(fixture.x(1), 2);
  });
}

test('weights are undone where somebody else has removed lattice 0', async (t) => {
  const fixture = await SessionFixture.live(t);
  const { session, stream } = fixture;
  states(fixture, [0, 1], 1n, 1n);
  states(fixture, [1], 2n, 2n);
  assert.ok(!session.canUndo);
  session.setWeights([0], Float32Array.of(0.5));
  accepted(fixture, 3n, 3n);
  states(fixture, [1], 3n, 3n);
  assert.ok(session.canUndo);
  session.undo();
  assert.equal(stream.edits[1]!.lattice, 0);
  accepted(fixture, 4n, 4n);
  assert.ok(!session.canUndo);
  assert.ok(session.canRedo);
});

/** A window that has moved a point of lattice 1, and then removed it. */
async function removed(t: TestContext): Promise<SessionFixture> {
  const fixture = await SessionFixture.live(t);
  states(fixture, [0, 1], 1n, 1n);
  fixture.session.chooseLattice(1);
  fixture.session.removeLattice();
  accepted(fixture, 2n, 2n);
  states(fixture, [0], 2n, 2n);
  assert.ok(fixture.session.canUndo);
  return fixture;
}

test('undo is of the lattice that is shown once somebody else has given the removed one back', async (t) => {
  const fixture = await removed(t);
  const { session, stream } = fixture;
  states(fixture, [0, 1], 3n, 3n);
  assert.ok(!session.canUndo);
  session.apply(move(0.5));
  accepted(fixture, 4n, 3n);
  session.undo();
  assert.equal(stream.edits.at(-1)!.lattice, 0);
});

test('a removal that the server cannot undo is not asked for again', async (t) => {
  const { session, stream } = await removed(t);
  session.undo();
  const status = refusal(9, 'NOTHING_TO_UNDO', 'nothing to undo');
  stream.event({ case: 'editResult', value: { sequence: stream.edits.at(-1)!.sequence, revision: 2n, structureId: 2n, status } });
  assert.ok(!session.canUndo);
});

test("a removal by somebody else is not taken for this window's redo, though it made one on the lattice", async (t) => {
  const fixture = await SessionFixture.live(t);
  const { session } = fixture;
  states(fixture, [0, 1], 1n, 1n);
  session.chooseLattice(1);
  const steps = [() => session.apply(move(0.5)), () => session.undo(), () => session.redo()];
  steps.forEach((step, i) => {
    step();
    accepted(fixture, BigInt(i + 2), 1n);
    fixture.stream.event({ case: 'latticeDelta', value: { structureId: 1n, revision: BigInt(i + 2), lattice: 1, indices: [1], positions: [i, 0, 0] } });
  });
  states(fixture, [0], 5n, 5n);
  assert.equal(session.shownLatticeIndex, 0);
  assert.ok(!session.canUndo);
});

test('a lattice that another window removes ends the move of this one', async (t) => {
  const fixture = await SessionFixture.live(t);
  const { session, stream } = fixture;
  states(fixture, [0, 1], 1n, 2n);
  session.chooseLattice(1);
  const told: string[] = [];
  session.on('refused', (text) => told.push(text));
  session.gesture();
  states(fixture, [0], 2n, 3n);
  assert.equal(session.shownLatticeIndex, 0);
  assert.equal(told.length, 1);
  assert.ok(!session.canUndo);
  session.addLattice(cubeLattice());
  assert.equal(stream.edits.at(-1)!.lattice, 1, 'the lowest number that is free');
});

/** An update of patches at this revision, whose bounds are of another layout. */
function patches(fixture: SessionFixture, revision: bigint): void {
  const { stream } = fixture;
  const topologyId = `layout-${revision}`;
  stream.event({ case: 'topology', value: { topologyId, patchCount: 1n, chunkRuns: [{ chunkCount: 1, patchesPerChunk: 1 }] } });
  stream.event({ case: 'updateBegin', value: { updateId: revision, view: { encoding: Encoding.PATCHES, normals: NormalMode.FACET } } });
  stream.event({ case: 'chunks', value: { updateId: revision, topologyId, chunks: [{ index: 0, data: Uint8Array.of(1, 2, 3) }] } });
  stream.event({ case: 'updateEnd', value: { updateId: revision, revision } });
}

test('bounds that come while the shown lattice is gone are of the only one that is left', async (t) => {
  const fixture = await SessionFixture.live(t);
  const { session, stream, surface: { edgeBounds } } = fixture;
  const larger = fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [4, 4, 4], degree: [2, 2, 2], padding: 0 });
  const state = (lattice: typeof larger, index: number, indexes: number[], revision: bigint): void => {
    const value = { lattice: fromLattice(lattice), structureId: revision + 1n, revision, index, indexes };
    stream.event({ case: 'latticeState', value });
  };
  state(cubeLattice(), 0, [0, 1], 1n);
  state(larger, 1, [0, 1], 1n);
  session.chooseLattice(1);
  assert.equal(session.lattice.size[0], 4);
  session.apply(move(0.25));
  assert.ok(session.hasShownLattice);

  state(cubeLattice(), 0, [0], 2n);
  assert.ok(!session.hasShownLattice, 'its edit waits for an answer');
  assert.equal(session.lattice.size[0], 4);
  patches(fixture, 2n);
  await until(() => edgeBounds.layout?.id === 'layout-2');
  assert.equal(edgeBounds.structure?.size[0], 3);

  const status = refusal(9, 'LATTICE_REMOVED', 'lattice 1 was removed');
  stream.event({ case: 'editResult', value: { sequence: stream.edits[0]!.sequence, revision: 2n, structureId: 3n, status } });
  assert.ok(session.hasShownLattice);
  assert.equal(session.lattice.size[0], 3);
  assert.equal(edgeBounds.structure?.size[0], 3);
});

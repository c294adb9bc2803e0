// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Own edits on top of the server's lattice: what the cage shows and what is sent after each answer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GesturePhase } from 'latticed/v1/edit_pb';
import { Lattice } from '@src/lattice/lattice';
import { refusal } from '../../support/fake_stream';
import { cubeLattice, SessionFixture, until } from '../../support/session_fixture';
import { fitLattice } from '@src/lattice/fitted_lattice';

const one = Uint32Array.of(1);
const move = (x: number, indices = one) => ({ kind: 'move', indices, offset: [x, 0, 0] }) as const;

test('an edit is shown at once and stays where it is until answer and delta are here, in either order', async (t) => {
  for (const answerFirst of [true, false]) {
    const fixture = await SessionFixture.live(t);
    const moved: number[][] = [];
    fixture.session.on('points', (indices) => moved.push([...indices]));

    fixture.session.apply(move(0.25));
    assert.equal(fixture.x(1), 0.75);
    const [batch] = fixture.stream.edits;
    assert.equal(batch.structureId, 1n);
    if (answerFirst) fixture.accept(batch.sequence, 1n);
    assert.equal(fixture.x(1), 0.75);
    fixture.delta(1n, [1], [0.75, 0, 0]);
    if (!answerFirst) fixture.accept(batch.sequence, 1n);

    assert.equal(fixture.x(1), 0.75);
    assert.deepEqual(moved, [[1]]);  // once: the delta moves nothing more
    fixture.delta(2n, [1], [0.1, 0, 0], 'somebody');
    assert.equal(fixture.x(1), 0.1);
  }
});

test('one batch is in flight; of what waits only the newest update of a gesture goes, made of its begin', async (t) => {
  const fixture = await SessionFixture.live(t);
  const gesture = fixture.session.gesture();

  for (const x of [0.1, 0.2, 0.3, 0.4]) gesture.update(move(x));
  assert.equal(fixture.x(1), 0.9);
  assert.equal(fixture.stream.edits.length, 1);
  fixture.delta(1n, [1], [0.6, 0, 0]);
  fixture.accept(fixture.stream.edits[0].sequence, 1n);

  const [first, second] = fixture.stream.edits;
  assert.equal(fixture.stream.edits.length, 2);
  assert.equal(fixture.x(1), 0.9);  // the delta of the first update does not pull the cage back
  assert.equal(second.gestureId, first.gestureId);
  assert.ok(second.sequence > first.sequence);
  assert.equal(second.edits[0].edit.case === 'moveControlPoints' && second.edits[0].edit.value.offset?.x, 0.4);
});

test('a commit takes the update that waits with it, and goes bare where none does', async (t) => {
  const fixture = await SessionFixture.live(t);
  const gesture = fixture.session.gesture();
  gesture.update(move(0.1));
  gesture.update(move(0.2));
  gesture.commit();
  fixture.accept(fixture.stream.edits[0].sequence, 1n);
  assert.equal(fixture.stream.edits[1].gesturePhase, GesturePhase.COMMIT);
  assert.equal(fixture.stream.edits[1].edits.length, 1);
  fixture.accept(fixture.stream.edits[1].sequence, 2n);

  const bare = fixture.session.gesture();
  bare.update(move(0.1));
  fixture.accept(fixture.stream.edits[2].sequence, 3n);
  bare.commit();

  assert.equal(fixture.stream.edits[3].gesturePhase, GesturePhase.COMMIT);
  assert.equal(fixture.stream.edits[3].edits.length, 0);
});

test('a gesture puts back points that its next update leaves out, and all of them when it is cancelled', async (t) => {
  const fixture = await SessionFixture.live(t);
  const gesture = fixture.session.gesture();
  gesture.update(move(0.1));
  gesture.update(move(0.2, Uint32Array.of(2)));
  assert.deepEqual([fixture.x(1), fixture.x(2)], [0.5, 1.2]);

  gesture.cancel();

  assert.deepEqual([fixture.x(1), fixture.x(2)], [0.5, 1]);
  fixture.accept(fixture.stream.edits[0].sequence, 1n);
  assert.deepEqual(fixture.stream.edits.map(({ gesturePhase }) => gesturePhase), [GesturePhase.UPDATE, GesturePhase.CANCEL]);
});

test('a gesture that is cancelled before anything of it was sent sends nothing', async (t) => {
  const fixture = await SessionFixture.live(t);
  fixture.session.apply(move(0.1));
  const gesture = fixture.session.gesture();
  gesture.update(move(0.2));
  gesture.cancel();
  fixture.accept(fixture.stream.edits[0].sequence, 1n);

  assert.equal(fixture.stream.edits.length, 1);
  assert.equal(fixture.x(1), 0.6);
});

test('a refused edit goes back to the server\'s place and is said in words; the next one goes', async (t) => {
  const fixture = await SessionFixture.live(t);
  const idle: unknown[] = [];
  fixture.session.on('refused', (_, nothing) => idle.push(nothing));
  fixture.session.apply(move(0.25));
  fixture.session.undo();
  const { sequence } = fixture.stream.edits[0];
  const status = refusal(3, 'NOT_FINITE', 'edits[0].move_control_points.offset: not finite');
  fixture.stream.event({ case: 'editResult', value: { sequence, status, revision: 0n } });

  assert.equal(fixture.x(1), 0.5);
  assert.deepEqual(fixture.said, ['Edits[0].move_control_points.offset: not finite.']);
  assert.equal(fixture.stream.edits[1].edits[0].edit.case, 'undo');
  fixture.stream.event({ case: 'editResult', value: {
    sequence: fixture.stream.edits[1].sequence, status: refusal(9, 'NOTHING_TO_UNDO', 'nothing'), revision: 0n } });
  assert.equal(fixture.said[1], 'There is nothing to undo.');
  assert.deepEqual(idle, [false, true]);
});

test('another structure drops what waits for the old one, says so, and ends the open gesture', async (t) => {
  const fixture = await SessionFixture.live(t);
  let seen = 0;
  fixture.session.on('lattice', (lattice) => (seen = lattice.count));
  const gesture = fixture.session.gesture();
  gesture.update(move(0.1));
  gesture.update(move(0.2));
  const wide = cubeLattice();

  fixture.state(wide, 2n, 1n);
  const { sequence } = fixture.stream.edits[0];
  fixture.stream.event({ case: 'editResult', value: { sequence, status: refusal(10, 'STRUCTURE_CHANGED', 'changed'), revision: 1n } });
  gesture.update(move(0.3));

  assert.equal(seen, 27);
  assert.equal(fixture.x(1), 0.5);
  assert.equal(fixture.stream.edits.length, 1);
  assert.equal(fixture.said.length, 2);
  assert.match(fixture.said[0], /unsent edits were dropped/);
  fixture.session.apply(move(0.1));
  assert.equal(fixture.stream.edits[1].structureId, 2n);
});

const like = cubeLattice();
const unit = { min: [0, 0, 0], max: [1, 1, 1] } as const;
for (const [what, lattice] of [
  ['degree', fitLattice(unit, { size: [3, 3, 3], degree: [1, 2, 2], padding: 0 })],
  ['frame', fitLattice({ ...unit, max: [1, 1, 2] }, { size: [3, 3, 3], degree: [2, 2, 2], padding: 0 })],
  ['knots', new Lattice(like.frame, like.degree, like.size, [Float64Array.of(0, 0, 0, 2, 2, 2), like.knots[1], like.knots[2]], like.points)],
] as const) {
  test(`a lattice that differs in its ${what} is another, also with as many control points and under the same id`, async (t) => {
    const fixture = await SessionFixture.live(t);
      const shown: Lattice[] = [];
    let ended = 0;
    fixture.session.on('lattice', (other) => shown.push(other));
    const gesture = fixture.session.gesture({ ended: () => ++ended });
    gesture.update(move(0.1));
    gesture.update(move(0.2));
    fixture.accept(fixture.stream.edits[0].sequence, 1n); // the second update is sent
    gesture.update(move(0.3)); // the third update waits

    fixture.state(lattice, 1n, 2n);
    fixture.accept(fixture.stream.edits[1].sequence, 3n);

    assert.deepEqual(shown.map(({ degree, size, frame, knots }) => ({ degree, size, frame, knots })),
      [{ degree: lattice.degree, size: lattice.size, frame: lattice.frame, knots: lattice.knots }]);
    assert.equal(fixture.session.lattice, shown[0]);
    assert.equal(ended, 1);
    assert.equal(fixture.stream.edits.length, 2);
    assert.deepEqual(fixture.said, ['The lattice got other control points meanwhile, so unsent edits were dropped.']);
  });
}

test('a lattice that is the same is none, however often it comes', async (t) => {
  const fixture = await SessionFixture.live(t);
  fixture.session.on('lattice', () => assert.fail('another lattice'));
  const gesture = fixture.session.gesture();
  gesture.update(move(0.1));
  fixture.state(cubeLattice(), 1n, 1n);
  gesture.update(move(0.2));
  fixture.accept(fixture.stream.edits[0].sequence, 2n);
  assert.equal(fixture.stream.edits.length, 2);
  assert.deepEqual(fixture.said, []);
});

test('another structure ends the open gesture, which is told and said, also where all of it was answered', async (t) => {
  const fixture = await SessionFixture.live(t);
  let ended = 0;
  const listener = { ended: () => ++ended };
  fixture.session.gesture(listener).commit();
  const gesture = fixture.session.gesture(listener);
  gesture.update(move(0.1));
  fixture.delta(1n, [1], [0.6, 0, 0]);
  fixture.accept(fixture.stream.edits[0].sequence, 1n);
  fixture.state(cubeLattice(), 2n, 2n);
  fixture.state(cubeLattice(), 3n, 3n);

  assert.equal(ended, 1);
  assert.deepEqual(fixture.said, ['The lattice got other control points meanwhile, so your move ended.']);
});

test('an edit beside an open gesture commits that, which is told, and goes after it', async (t) => {
  const fixture = await SessionFixture.live(t);
  let ended = 0;
  const gesture = fixture.session.gesture({ ended: () => ++ended });
  gesture.update(move(0.1));
  fixture.session.undo();
  gesture.update(move(0.2));
  for (let i = 1; i < 3; ++i) fixture.accept(fixture.stream.edits.at(-1)!.sequence, BigInt(i));

  assert.equal(ended, 1);
  assert.deepEqual(fixture.stream.edits.map(({ gesturePhase }) => gesturePhase),
    [GesturePhase.UPDATE, GesturePhase.COMMIT, GesturePhase.UNSPECIFIED]);
  assert.equal(fixture.stream.edits[2].edits[0].edit.case, 'undo');
  assert.deepEqual(fixture.said, []);
});

test('turning, setting and replacing points do what the server will', async (t) => {
  const fixture = await SessionFixture.live(t);
  const quarterTurn = Float64Array.of(0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);
  fixture.session.apply({ kind: 'transform', indices: one, matrix: quarterTurn });
  assert.deepEqual([...fixture.session.lattice.points.slice(3, 6)], [0, 0.5, 0]);

  fixture.session.apply({ kind: 'set', indices: one, positions: Float64Array.of(7, 8, 9) });
  assert.deepEqual([...fixture.session.lattice.points.slice(3, 6)], [7, 8, 9]);

  fixture.session.replace(cubeLattice().points);
  assert.equal(fixture.x(1), 0.5);
});

test('an update says how long ago the own edit was that the server has applied with it, and of others nothing', async (t) => {
  const fixture = await SessionFixture.live(t);
  let now = 1000;
  t.mock.method(performance, 'now', () => now);
  const ages: (number | undefined)[] = [];
  fixture.session.on('update', ({ msFromEdit }) => ages.push(msFromEdit));
  const update = async (updateId: bigint, appliedSequence: bigint): Promise<void> => {
    fixture.stream.event({ case: 'updateBegin', value: { updateId, revision: updateId } });
    fixture.stream.event({ case: 'updateEnd', value: { updateId, revision: updateId, appliedSequence } });
    await until(() => ages.length === Number(updateId));
  };

  fixture.session.apply(move(0.1));
  const [{ sequence }] = fixture.stream.edits;
  now = 1040;
  await update(1n, 0n);
  await update(2n, sequence);
  await update(3n, sequence);

  assert.deepEqual(ages, [undefined, 40, undefined]);
});

test('steps to undo and to redo are counted by the answers, and not those that were refused or cancelled', async (t) => {
  const fixture = await SessionFixture.live(t);
  const { session } = fixture;
  const can = (): string => [session.canUndo && 'undo', session.canRedo && 'redo'].filter(Boolean).join();
  let revision = 0n;
  const answered = (): string => {
    fixture.accept(fixture.stream.edits.at(-1)!.sequence, ++revision);
    return can();
  };
  const cancelled = session.gesture();
  cancelled.update(move(0.5));
  assert.equal(answered(), '');
  cancelled.cancel();
  assert.equal(answered(), '');
  const gesture = session.gesture();
  gesture.update(move(0.5));
  assert.equal(answered(), '');
  gesture.commit();
  assert.equal(answered(), 'undo');

  session.undo();
  assert.equal(answered(), 'redo');
  session.redo();
  assert.equal(answered(), 'undo');
  session.undo();
  answered();
  session.apply(move(0.25));
  assert.equal(answered(), 'undo');
  session.undo();
  assert.equal(answered(), 'redo');
  const tried = session.gesture();
  tried.update(move(0.5));
  answered();
  tried.cancel();
  assert.equal(answered(), '', 'the server has forgotten what was undone');
  session.apply(move(0.25));
  assert.equal(answered(), 'undo');
  session.undo();
  fixture.stream.event({ case: 'editResult', value: {
    sequence: fixture.stream.edits.at(-1)!.sequence, status: refusal(9, 'NOTHING_TO_UNDO', 'nothing'), revision: 0n } });
  assert.equal(can(), '');
});

test('a slide of the strength is shown at once, is one gesture, and goes back when it is cancelled or refused', async (t) => {
  const fixture = await SessionFixture.live(t);
  const { session } = fixture;
  const moved: number[] = [];
  session.on('points', (indices) => moved.push(indices.length));
  const gesture = session.gesture();

  gesture.update({ kind: 'strength', strength: 0.5 });
  assert.equal(session.lattice.strength, 0.5);
  assert.deepEqual(moved, [session.lattice.count]); // all of the surface follows
  fixture.accept(fixture.stream.edits[0].sequence, 1n);
  fixture.stream.event({ case: 'latticeDelta', value: { structureId: 1n, revision: 1n, strength: 0.5 } });
  assert.equal(moved.length, 1);
  gesture.update({ kind: 'strength', strength: 0.25 });
  const [first, second] = fixture.stream.edits;
  assert.equal(second.gestureId, first.gestureId);
  assert.deepEqual(second.edits[0].edit.case === 'setStrength' && second.edits[0].edit.value.strength, 0.25);
  gesture.cancel();
  assert.equal(session.lattice.strength, 1);

  fixture.stream.event({ case: 'editResult', value: { sequence: second.sequence, revision: 2n, structureId: 1n } });
  fixture.stream.event({ case: 'latticeDelta', value: { structureId: 1n, revision: 2n, strength: 0.25 } });
  assert.equal(session.lattice.strength, 1);
  fixture.accept(fixture.stream.edits[2].sequence, 3n);
  fixture.stream.event({ case: 'latticeDelta', value: { structureId: 1n, revision: 3n, strength: 1 } });
  session.apply({ kind: 'strength', strength: 0.75 });
  assert.equal(session.lattice.strength, 0.75);
  fixture.stream.event({ case: 'editResult', value: {
    sequence: fixture.stream.edits[3].sequence, status: refusal(9, 'FOLD', 'folds'), revision: 3n } });
  assert.equal(session.lattice.strength, 1);
});

test('what a parent carries is shown with the server\'s answer, which whoever asked is told', async (t) => {
  const fixture = await SessionFixture.live(t);
  const parent = cubeLattice();
  parent.points.set([7, 8, 9]);
  const told: (string | undefined)[] = [];
  const carry = (indices: number[]): void => fixture.session.carry(indices, parent, (refusal) => told.push(refusal));

  carry([1]);
  assert.equal(fixture.x(1), 0.5);
  const [{ edits: [{ edit }], sequence, gestureId }] = fixture.stream.edits;
  assert.ok(edit.case === 'carryControlPoints');
  assert.deepEqual(edit.value.indices, [1]);
  assert.deepEqual(edit.value.parent!.controlPoints.slice(0, 3), [7, 8, 9]);
  assert.equal(gestureId, '');
  fixture.delta(1n, [1], [0.75, 0, 0]);
  assert.equal(fixture.x(1), 0.75);
  assert.deepEqual(told, []);
  fixture.accept(sequence, 1n);
  assert.deepEqual(told, [undefined]);
  assert.ok(fixture.session.canUndo);

  carry([]);
  const status = refusal(3, 'INVALID_ARGUMENT', 'edits[0].carry_control_points.parent: is wrong');
  fixture.stream.event({ case: 'editResult', value: { sequence: fixture.stream.edits[1].sequence, status, revision: 1n } });
  assert.deepEqual(told.slice(1), ['Edits[0].carry_control_points.parent: is wrong.']);
  assert.deepEqual(fixture.said, told.slice(1));
});

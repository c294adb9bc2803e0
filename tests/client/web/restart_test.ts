// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server that was restarted and keeps nothing, where another window was quicker to restore the scene.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Code, ConnectError } from '@connectrpc/connect';
import { GesturePhase } from 'latticed/v1/edit_pb';
import type { LatticeEdit } from '@src/session/edits/lattice_edit';
import type { LiveSession } from '@src/session/live_session';
import type { Gesture } from '@src/session/scene_session';
import { ServerError } from '@src/wire/server_error';
import { SessionFixture, cubeLattice, until } from './support/session_fixture';
import { fitLattice } from './support/fitted_lattice';

const LET_GO = 'The server was restarted, so what was being moved was let go where it was.';
const move = (x: number): LatticeEdit => ({ kind: 'move', indices: Uint32Array.of(1), offset: [x, 0, 0] });

/** A window of a scene that another one made again on the next run of the server, with these edits of its own unanswered. */
async function restoredElsewhere(edit: (session: LiveSession) => void, isMissed: boolean): Promise<SessionFixture> {
  const fixture = await SessionFixture.live();
  edit(fixture.session);
  fixture.server.bootId = 'boot-2';
  await fixture.store.saveScene({ ...(await fixture.store.scene('scene-0001'))!, bootId: 'boot-2' });
  fixture.stream.end(isMissed ? new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001') : undefined);
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello('boot-2');
  return fixture;
}

for (const isMissed of [true, false]) {
  const when = isMissed ? 'before this one could' : 'before this one came back';
  test(`a scene that another window made again ${when} is gone on with; own edits go again, as places`, async () => {
    const fixture = await restoredElsewhere((session) => {
      session.apply(move(0.25));
      const gesture = session.gesture();
      gesture.update({ kind: 'move', indices: Uint32Array.of(1, 2), offset: [0, 0.5, 0] });
    }, isMissed);
    assert.equal(fixture.stream.edits.length, 0); // the server has forgotten the sequences
    const made = cubeLattice();
    made.points[3] = 0.75; // the other window had the first edit
    fixture.state(made);

    assert.equal(fixture.server.scenes.size, 0, 'nothing is made twice');
    assert.equal(fixture.session.status.state, 'restored');
    assert.match(fixture.session.status.text, /another window restored/);
    const [{ edits }] = fixture.stream.edits;
    const [{ edit }] = edits;
    assert.ok(edit.case === 'setControlPoints');
    assert.deepEqual(edit.value.indices, [1, 2]);
    assert.deepEqual(edit.value.positions, [0.75, 0.5, 0, 1, 0.5, 0]);
    assert.equal(fixture.x(1), 0.75);
    assert.deepEqual(fixture.said, [LET_GO]);
    fixture.session.close();
  });
}

test('a gesture that a restart of the server interrupts ends where it was, which is told and said', async () => {
  let gesture!: Gesture;
  let ended = 0;
  const fixture = await restoredElsewhere((session) => {
    gesture = session.gesture({ ended: () => ++ended });
    gesture.update(move(0.25));
  }, false);
  fixture.state();
  assert.equal(fixture.stream.edits.length, 1);

  gesture.update(move(0.5)); // of a begin that the server does not know
  gesture.commit();

  assert.equal(fixture.stream.edits.length, 1);
  assert.equal(fixture.x(1), 0.75);
  assert.equal(ended, 1);
  assert.deepEqual(fixture.said, [LET_GO]);
  fixture.session.close();
});

test('own edits that a restored scene cannot take are dropped, in words', async () => {
  const steps = await restoredElsewhere((session) => session.undo(), true);
  assert.match(steps.said.join(), /restarted before it had answered all edits/);
  steps.state();
  assert.equal(steps.stream.edits.length, 0);
  steps.session.close();

  const points = await restoredElsewhere((session) =>
    session.apply(move(0.25)), true);
  points.state(fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [4, 3, 3], degree: [2, 2, 2], padding: 0 }));
  assert.match(points.said.join(), /other control points meanwhile/);
  assert.equal(points.stream.edits.length, 0);
  points.session.close();
});

test('an edit that is made while this window restores the scene is sent to it', async () => {
  const fixture = await SessionFixture.live();
  fixture.server.bootId = 'boot-2';
  fixture.session.apply(move(0.25)); // in flight, and in the lattice that the scene is made with
  const { scenes } = fixture.server;
  scenes.set = (id, request) => { // as the server makes the scene
    fixture.session.apply({ kind: 'move', indices: Uint32Array.of(2), offset: [0, 0.5, 0] });
    return Map.prototype.set.call(scenes, id, request);
  };
  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello('boot-2');
  const made = cubeLattice();
  made.points[3] = 0.75;
  fixture.state(made);

  const sent = fixture.stream.edits.map(({ edits: [{ edit }] }) => edit.case === 'setControlPoints' && edit.value.indices);
  assert.deepEqual(sent, [[2]]);
  assert.equal(fixture.session.lattice.points[7], 0.5);
  assert.match(fixture.session.status.text, /this browser restored/);
  fixture.session.close();
});

/** What the newest stream was sent of control points put in places. */
function placed(fixture: SessionFixture): [indices: number[], positions: number[]][] {
  return fixture.stream.edits.flatMap(({ edits }) => edits).map(({ edit }) => {
    assert.ok(edit.case === 'setControlPoints', edit.case);
    return [edit.value.indices, edit.value.positions];
  });
}

async function streamEnds(fixture: SessionFixture): Promise<void> {
  const { length } = fixture.sockets.opened;
  fixture.stream.end();
  await until(() => fixture.sockets.opened.length === length + 1);
}

test('a server that goes once more while this window restores the scene is asked again after a pause', async (t) => {
  const fixture = await SessionFixture.live({ backOff: { firstMs: 400, lastMs: 400 } });
  t.after(() => fixture.session.close());
  const gone = new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001');
  fixture.server.bootId = 'boot-2';
  fixture.server.refusal = new ConnectError('reset', Code.Unavailable);
  fixture.stream.end(gone);
  await until(() => /cannot be reached\. Trying again …$/.test(fixture.session.status.text));
  assert.equal(fixture.sockets.opened.length, 1);
  await until(() => fixture.sockets.opened.length === 2);

  fixture.server.refusal = undefined;
  fixture.stream.end(gone);
  await until(() => fixture.sockets.opened.length === 3);
  fixture.stream.hello('boot-2');

  assert.match(fixture.session.status.text, /this browser restored/);
  assert.deepEqual([...fixture.server.scenes.keys()], ['scene-0001']);
});

test('what this browser cannot read of the scene is not tried again, in words', async (t) => {
  const fixture = await SessionFixture.live();
  t.after(() => fixture.session.close());
  fixture.server.bootId = 'boot-2';
  fixture.store.scene = () => Promise.reject(new Error('another window has a newer version of this page: reload this one'));
  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.session.status.state === 'failed');

  assert.equal(fixture.session.status.text, 'another window has a newer version of this page: reload this one.');
  assert.equal(fixture.sockets.opened.length, 1);
});

test('own edits go again, and who restored the scene stays known, where its first stream does not open', async (t) => {
  const fixture = await SessionFixture.live();
  t.after(() => fixture.session.close());
  fixture.server.bootId = 'boot-2';
  fixture.session.apply(move(0.25));
  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.sockets.opened.length === 2);
  await streamEnds(fixture); // before its hello
  fixture.stream.hello('boot-2');
  fixture.state(); // of another window, which made the scene without the edit

  assert.deepEqual(placed(fixture), [[[1], [0.75, 0, 0]]]);
  assert.match(fixture.session.status.text, /this browser restored/);
  await streamEnds(fixture);
  fixture.stream.hello('boot-2');
  assert.equal(fixture.session.status.state, 'live', 'told once');
});

test('own edits go again, as their newest places, where the server restarts twice before a lattice has come', async (t) => {
  const fixture = await restoredElsewhere((session) => {
    session.apply(move(0.25));
    session.apply({ kind: 'move', indices: Uint32Array.of(2), offset: [0, 0.5, 0] });
  }, false);
  t.after(() => fixture.session.close());
  fixture.session.apply(move(0.25));
  await streamEnds(fixture);
  fixture.stream.hello('boot-3');
  fixture.state();

  assert.deepEqual(placed(fixture), [[[1, 2], [1, 0, 0, 1, 0.5, 0]]]);
  assert.deepEqual([fixture.x(1), fixture.session.lattice.points[7]], [1, 0.5]);
  assert.deepEqual(fixture.said, []);
});

/** A window whose point 1 was put at 0.75 without an answer, on the stream of a restored scene that has not opened. */
async function reopened(): Promise<SessionFixture> {
  const fixture = await SessionFixture.live();
  fixture.session.apply(move(0.25));
  await streamEnds(fixture);
  return fixture;
}

test('what is done between a restart and the restored lattice goes after what is repeated, and a drag goes on', async (t) => {
  const fixture = await reopened();
  t.after(() => fixture.session.close());
  fixture.stream.hello('boot-2');
  fixture.session.apply(move(0.125));
  const gesture = fixture.session.gesture();
  gesture.update({ kind: 'move', indices: Uint32Array.of(1, 2), offset: [0, 0.5, 0] });
  assert.equal(fixture.stream.edits.length, 0);
  fixture.state();
  const shown = (): number[] => [...fixture.session.lattice.points.slice(3, 9)];
  assert.deepEqual(shown(), [0.875, 0.5, 0, 1, 0.5, 0]);
  gesture.update({ kind: 'move', indices: Uint32Array.of(1, 2), offset: [0, 0.75, 0] });
  gesture.commit();
  for (const count of [1, 2, 3]) {
    assert.equal(fixture.stream.edits.length, count);
    fixture.accept(fixture.stream.edits.at(-1)!.sequence, BigInt(count));
  }

  const [repeated, step, drag] = fixture.stream.edits;
  assert.ok(repeated.sequence < step.sequence && step.sequence < drag.sequence);
  const edits = [repeated, step, drag].map((batch) => batch.edits[0].edit);
  assert.deepEqual(edits.map((edit) => edit.case), ['setControlPoints', 'moveControlPoints', 'moveControlPoints']);
  assert.ok(edits[0].case === 'setControlPoints' && edits[2].case === 'moveControlPoints');
  assert.deepEqual(edits[0].value.positions, [0.75, 0, 0]);
  assert.equal(edits[2].value.offset?.y, 0.75);
  assert.deepEqual(shown(), [0.875, 0.75, 0, 1, 0.75, 0]);
  assert.deepEqual(fixture.said, []);
});

test('what is done before a restored lattice comes under another structure id is sent under that', async (t) => {
  const fixture = await reopened();
  t.after(() => fixture.session.close());
  let ended = 0;
  fixture.session.gesture({ ended: () => ++ended }).update({ kind: 'move', indices: Uint32Array.of(2), offset: [0, 0.5, 0] });
  fixture.stream.hello('boot-2');
  fixture.session.apply(move(0.125));
  const gesture = fixture.session.gesture({ ended: () => ++ended });
  gesture.update({ kind: 'move', indices: Uint32Array.of(3), offset: [0, 0, 1] });
  fixture.state(cubeLattice(), 7n);
  gesture.update({ kind: 'move', indices: Uint32Array.of(3), offset: [0, 0, 2] });
  assert.deepEqual([fixture.x(1), fixture.session.lattice.points[7]], [0.875, 0.5]);
  for (let i = 0; i < 3; ++i) fixture.accept(fixture.stream.edits.at(-1)!.sequence, BigInt(i + 1));

  const [repeated, ...rest] = fixture.stream.edits.map(({ edits: [{ edit }] }) => edit);
  assert.ok(repeated.case === 'setControlPoints');
  assert.deepEqual([repeated.value.indices, repeated.value.positions], [[1, 2], [0.75, 0, 0, 1, 0.5, 0]]);
  assert.deepEqual(rest.map((edit) => edit.case), ['moveControlPoints', 'moveControlPoints']);
  assert.ok(fixture.stream.edits.every(({ structureId }) => structureId === 7n));
  assert.equal(fixture.stream.edits[2].gesturePhase, GesturePhase.COMMIT);
  assert.equal(fixture.session.lattice.points[11], 1);
  assert.equal(ended, 2);
  assert.deepEqual(fixture.said, [LET_GO, LET_GO]);
});

test('what is done before a restored lattice of another structure comes is dropped, in words', async (t) => {
  const fixture = await restoredElsewhere(() => {}, false);
  t.after(() => fixture.session.close());
  fixture.session.apply(move(0.25));
  fixture.state(fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [4, 3, 3], degree: [2, 2, 2], padding: 0 }));

  assert.match(fixture.said.join(), /other control points meanwhile/);
  assert.equal(fixture.stream.edits.length, 0);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A restarted server that kept nothing, and edits that it never answered, in orders that no test in a browser can set.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { Code, ConnectError } from '@connectrpc/connect';
import { GesturePhase } from 'latticed/v1/edit_pb';
import type { LatticeEdit } from '@src/session/edits/lattice_edit';
import { SessionFixture, cubeLattice, noScene, until } from './support/session_fixture';
import { fitLattice } from '@src/lattice/fitted_lattice';

const LET_GO = 'The server was restarted, so your move ended and keeps its last position.';
const OTHER_STRUCTURE = fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [4, 3, 3], degree: [2, 2, 2], padding: 0 });

const move = (x: number): LatticeEdit => ({ kind: 'move', indices: Uint32Array.of(1), offset: [x, 0, 0] });
const lift = (indices: number[], y: number): LatticeEdit => ({ kind: 'move', indices: Uint32Array.from(indices), offset: [0, y, 0] });

/** A window with these unanswered edits, on a restarted server where another window has restored the scene. */
async function restoredElsewhere(t: TestContext, ...edits: LatticeEdit[]): Promise<SessionFixture> {
  const fixture = await SessionFixture.live(t);
  for (const edit of edits) fixture.session.apply(edit);
  fixture.server.bootId = 'boot-2';
  await fixture.store.saveScene({ ...(await fixture.store.scene('scene-0001'))!, bootId: 'boot-2' });
  await fixture.reconnect();
  return fixture;
}

/** The edits sent on the newest stream. All of them must set control points. */
function placed(fixture: SessionFixture): [indices: number[], positions: number[]][] {
  return fixture.stream.edits.flatMap(({ edits }) => edits).map(({ edit }) => {
    assert.ok(edit.case === 'setControlPoints', edit.case);
    return [edit.value.indices, edit.value.positions];
  });
}

test('edits that a restored scene cannot take are dropped, in words, whether they were made before or after it was lost', async (t) => {
  const steps = await SessionFixture.live(t);
  steps.session.undo();
  await steps.reconnect(undefined, 'boot-2');
  assert.match(steps.said.join(), /restarted before it had answered all edits/);
  steps.state();
  assert.equal(steps.stream.edits.length, 0);

  const before = await restoredElsewhere(t, move(0.25));
  const after = await restoredElsewhere(t);
  after.session.apply(move(0.25));
  for (const points of [before, after]) {
    points.state(OTHER_STRUCTURE);
    assert.match(points.said.join(), /other control points meanwhile/);
    assert.equal(points.stream.edits.length, 0);
  }
});

test('an edit that is made while this window restores the scene is sent to it', async (t) => {
  const fixture = await SessionFixture.live(t);
  fixture.server.bootId = 'boot-2';
  fixture.session.apply(move(0.25)); // in flight; the scene is restored with it
  const { scenes } = fixture.server;
  scenes.set = (id, request) => { // while the server creates the scene
    fixture.session.apply(lift([2], 0.5));
    return Map.prototype.set.call(scenes, id, request);
  };
  await fixture.reconnect(noScene);
  const made = cubeLattice();
  made.points[3] = 0.75;
  fixture.state(made);

  assert.deepEqual(placed(fixture).map(([indices]) => indices), [[2]]);
  assert.equal(fixture.session.lattice.points[7], 0.5);
  assert.match(fixture.session.status.text, /this browser restored/);
});

test('a restored scene keeps its name and its crease angle', async (t) => {
  const fixture = await SessionFixture.live(t, { scene: { name: 'Torus', creaseAngle: 0 } });
  fixture.server.bootId = 'boot-2';
  await fixture.reconnect(noScene);

  const { name, creaseAngle } = fixture.server.scenes.get('scene-0001')!;
  assert.deepEqual({ name, creaseAngle }, { name: 'Torus', creaseAngle: 0 });
});

test('a server that goes once more while this window restores the scene is asked again after a pause', async (t) => {
  const fixture = await SessionFixture.live(t, { backOff: { firstMs: 400, lastMs: 400 } });
  fixture.server.bootId = 'boot-2';
  fixture.server.refusal = new ConnectError('reset', Code.Unavailable);
  fixture.stream.end(noScene);
  await until(() => /cannot be reached\. Trying again …$/.test(fixture.session.status.text));
  assert.equal(fixture.sockets.opened.length, 1);
  await until(() => fixture.sockets.opened.length === 2);

  fixture.server.refusal = undefined;
  await fixture.reconnect(noScene);

  assert.match(fixture.session.status.text, /this browser restored/);
  assert.deepEqual([...fixture.server.scenes.keys()], ['scene-0001']);
});

test('own edits go again, and who restored the scene stays known, where its first stream does not open', async (t) => {
  const fixture = await SessionFixture.live(t);
  fixture.server.bootId = 'boot-2';
  fixture.session.apply(move(0.25));
  await fixture.lose(noScene);
  await fixture.reconnect(); // the first stream ends before its hello
  fixture.state(); // another window has created the scene without the edit

  assert.deepEqual(placed(fixture), [[[1], [0.75, 0, 0]]]);
  assert.match(fixture.session.status.text, /this browser restored/);
  await fixture.reconnect();
  assert.equal(fixture.session.status.state, 'live', 'told once');
});

test('own edits go again, as their newest places, where the server restarts twice before a lattice has come', async (t) => {
  const fixture = await restoredElsewhere(t, move(0.25), lift([2], 0.5));
  fixture.session.apply(move(0.25));
  await fixture.reconnect(undefined, 'boot-3');
  fixture.state();

  assert.deepEqual(placed(fixture), [[[1, 2], [1, 0, 0, 1, 0.5, 0]]]);
  assert.deepEqual([fixture.x(1), fixture.session.lattice.points[7]], [1, 0.5]);
  assert.deepEqual(fixture.said, []);
});

/** A window that moved point 1 to 0.75 without an answer. Its stream to the restored scene has not opened yet. */
async function reopened(t: TestContext): Promise<SessionFixture> {
  const fixture = await SessionFixture.live(t);
  fixture.session.apply(move(0.25));
  await fixture.lose();
  return fixture;
}

test('what is done between a restart and the restored lattice goes after what is repeated, and a drag goes on', async (t) => {
  const fixture = await reopened(t);
  fixture.stream.hello('boot-2');
  fixture.session.apply(move(0.125));
  const gesture = fixture.session.gesture();
  gesture.update(lift([1, 2], 0.5));
  assert.equal(fixture.stream.edits.length, 0);
  fixture.state();
  const shown = (): number[] => [...fixture.session.lattice.points.slice(3, 9)];
  assert.deepEqual(shown(), [0.875, 0.5, 0, 1, 0.5, 0]);
  gesture.update(lift([1, 2], 0.75));
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
  const fixture = await reopened(t);
  let ended = 0;
  fixture.session.gesture({ ended: () => ++ended }).update(lift([2], 0.5));
  fixture.stream.hello('boot-2');
  fixture.session.apply(move(0.125));
  const gesture = fixture.session.gesture({ ended: () => ++ended });
  gesture.update(lift([3], 1));
  fixture.state(cubeLattice(), 7n);
  gesture.update(lift([3], 2));
  assert.deepEqual([fixture.x(1), fixture.session.lattice.points[7]], [0.875, 0.5]);
  for (let i = 0; i < 3; ++i) fixture.accept(fixture.stream.edits.at(-1)!.sequence, BigInt(i + 1));

  const [repeated, ...rest] = fixture.stream.edits.map(({ edits: [{ edit }] }) => edit);
  assert.ok(repeated.case === 'setControlPoints');
  assert.deepEqual([repeated.value.indices, repeated.value.positions], [[1, 2], [0.75, 0, 0, 1, 0.5, 0]]);
  assert.deepEqual(rest.map((edit) => edit.case), ['moveControlPoints', 'moveControlPoints']);
  assert.ok(fixture.stream.edits.every(({ structureId }) => structureId === 7n));
  assert.equal(fixture.stream.edits[2].gesturePhase, GesturePhase.COMMIT);
  assert.equal(fixture.session.lattice.points[10], 1.5);
  assert.equal(ended, 2);
  assert.deepEqual(fixture.said, [LET_GO, LET_GO]);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Streams that are lost, servers that restart, and what the window is told.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Code, ConnectError } from '@connectrpc/connect';
import { Feature } from 'latticed/v1/server_pb';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import { IndexedSceneStore } from '@src/session/store/indexed_scene_store';
import type { ViewRequest } from '@src/session/scene_session';
import { storedMesh } from '@src/session/store/scene_store';
import { ServerError } from '@src/wire/server_error';
import { inWords } from '@src/wire/words';
import { MemorySceneStore } from './support/memory_scene_store';
import { SessionFixture, until } from './support/session_fixture';

const unavailable = (): ServerError => new ServerError(Code.Unavailable, '', 'the connection is lost');
const HOUR = 3_600_000;
const move = { kind: 'move', indices: Uint32Array.of(1), offset: [0.25, 0, 0] } as const;

test('a lost stream is opened again where it stopped, and what was in flight is sent again as the same batch', async () => {
  const fixture = await SessionFixture.live();
  fixture.stream.event({ case: 'updateBegin', value: { updateId: 1n, revision: 0n } });
  fixture.stream.event({ case: 'updateEnd', value: { updateId: 1n, revision: 0n, resumeToken: Uint8Array.of(5) } });
  await until(() => fixture.stream.controls.length === 1);
  assert.equal(fixture.stream.controls[0].ackedUpdateId, 1n);
  fixture.session.apply(move);
  const { sequence } = fixture.stream.edits[0];

  fixture.stream.end(unavailable());
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello();

  assert.deepEqual([...fixture.stream.request.resumeToken!], [5]);
  assert.equal(fixture.stream.request.editorId, fixture.session.editorId);
  assert.deepEqual(fixture.stream.edits.map((batch) => batch.sequence), [sequence]);
  assert.equal(fixture.x(1), 0.75);
  assert.deepEqual(fixture.states, ['live', 'retrying', 'live']);
  fixture.session.close();
});

test('where twice no WebSocket opens but calls pass, gRPC-Web is used; where neither does, the socket is tried again', async () => {
  const fixture = new SessionFixture();
  fixture.server.refusal = new ConnectError('down', Code.Unavailable);
  fixture.stream.end(unavailable());
  await until(() => fixture.sockets.opened.length === 2);
  assert.equal(fixture.watches.opened.length, 0);

  fixture.server.refusal = undefined;
  fixture.stream.end(unavailable());
  await until(() => fixture.sockets.opened.length === 3);
  assert.equal(fixture.watches.opened.length, 0);
  fixture.stream.end(unavailable());
  await until(() => fixture.watches.opened.length === 1);

  fixture.watches.newest.hello();
  assert.equal(fixture.session.status.state, 'live');
  const { deadlines } = fixture.server;  // so that a dead connection of the browser's ends the call
  assert.ok(deadlines.length === 3 && deadlines.every((ms) => ms > 0 && ms <= 5000), `${deadlines}`);
  fixture.session.close();
});

test('a pick is waited for 10 seconds at most, and then said in words to have failed', async () => {
  const fixture = await SessionFixture.live({ features: [Feature.PICK] });

  await assert.rejects(fixture.session.pick([0, 0, 1], [0, 0, -1]), (error) => {
    assert.equal(inWords(error), 'The server did not answer in time.');
    return true;
  });

  const [ms] = fixture.server.deadlines;
  assert.ok(ms > 0 && ms <= 10_000, `${ms}`);
  fixture.session.close();
});

test('a network that comes back between a socket and a call leaves the socket; gRPC-Web that is lost tries it again', async () => {
  const fixture = new SessionFixture();
  fixture.stream.end(unavailable());
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello();
  fixture.stream.end(unavailable());  // heard: not of another kind
  await until(() => fixture.sockets.opened.length === 3);
  assert.equal(fixture.watches.opened.length, 0);

  fixture.stream.end(unavailable());
  await until(() => fixture.sockets.opened.length === 4);
  fixture.stream.end(unavailable());
  await until(() => fixture.watches.opened.length === 1);
  fixture.watches.newest.hello();
  fixture.watches.newest.end(unavailable());
  await until(() => fixture.sockets.opened.length === 5);

  assert.equal(fixture.watches.opened.length, 1);
  fixture.session.close();
});

test('when the network is back, or the page is looked at, no pause is waited for; a stream from before is not of use', async (t) => {
  const fixture = new SessionFixture({ backOff: { firstMs: HOUR, lastMs: HOUR } });
  t.after(() => fixture.session.close());
  fixture.stream.hello();
  fixture.awake!.seen();
  assert.equal(fixture.sockets.opened.length, 1);  // all is well

  const before = fixture.stream;
  fixture.awake!.networkBack();
  assert.equal(fixture.sockets.opened.length, 2);
  assert.ok(before.isClosed);
  fixture.stream.hello();
  fixture.stream.end(unavailable());
  fixture.awake!.networkBack();
  assert.equal(fixture.sockets.opened.length, 3);
  fixture.stream.hello();
  fixture.stream.end(unavailable());
  fixture.awake!.seen();
  assert.equal(fixture.sockets.opened.length, 4);

  assert.deepEqual(fixture.states, ['live', 'retrying', 'live', 'retrying', 'live', 'retrying']);
  fixture.session.close();
  assert.ok(fixture.awake === undefined);
});

test('a stream that was silent while the computer slept, by the clock, is opened again when the page is looked at', async (t) => {
  const fixture = new SessionFixture({ backOff: { firstMs: HOUR, lastMs: HOUR } });
  t.after(() => fixture.session.close());
  fixture.stream.hello('boot-1', 10_000);
  const { now } = Date;
  t.after(() => (Date.now = now));

  Date.now = () => now() + 29_000;
  fixture.awake!.seen();
  assert.equal(fixture.sockets.opened.length, 1);
  Date.now = () => now() + 31_000;
  fixture.awake!.seen();

  assert.equal(fixture.sockets.opened.length, 2);
});

test('a socket that is refused for its token fails with what the server says of it', async () => {
  const fixture = new SessionFixture();
  fixture.server.refusal = new ConnectError('unknown token', Code.Unauthenticated);
  fixture.stream.end(unavailable());
  await until(() => fixture.session.status.state === 'failed');

  assert.equal(fixture.session.status.text, 'Unknown token.');
  await assert.rejects(fixture.session.ready, /Unknown token/);
  assert.equal(fixture.sockets.opened.length, 1);
  fixture.session.close();
});

test('heartbeats go out, and three of silence end the stream', async (t) => {
  const timers: { name: string; act: () => void; ms: number }[] = [];
  const kept = ['setInterval', 'setTimeout'] as const;
  const fixture = new SessionFixture();
  const first = fixture.stream;
  const mocks = kept.map((name) => t.mock.method(globalThis, name, ((act: () => void, ms: number) => timers.push({ name, act, ms })) as never));
  first.hello('boot-1', 20);
  for (const { mock } of mocks) mock.restore();
  const [beat, silence] = kept.map((name) => timers.filter((timer) => timer.name === name).at(-1)!);

  beat.act();
  beat.act();
  assert.equal(beat.ms, 20);
  assert.equal(first.sent.filter(({ message }) => message.case === 'heartbeat').length, 2);
  assert.equal(silence.ms, 60);
  silence.act();
  await until(() => fixture.sockets.opened.length === 2);

  assert.ok(first.isClosed);
  assert.deepEqual(fixture.states, ['live', 'retrying']);
  fixture.session.close();
});

test('a view that is too large for the server is taken back to the one before, in words', async () => {
  const fixture = await SessionFixture.live();
  const views: ViewRequest[] = [];
  fixture.session.on('view', (view) => views.push(view));
  const view = { segments: 4, normals: NormalMode.FACET, encoding: Encoding.QUANTISED, positionBits: 12, normalBits: 8 };
  fixture.stream.event({ case: 'updateBegin', value: { updateId: 1n, view } });
  fixture.stream.event({ case: 'updateEnd', value: { updateId: 1n, fullDetail: true } });
  await until(() => fixture.stream.controls.length === 1);

  fixture.session.setView({ segments: 32 });
  const tooLarge = new ServerError(Code.ResourceExhausted, 'OUT_OF_MEMORY', 'the view needs 4491922512 bytes, 43616405 are free');
  fixture.stream.end(tooLarge);
  await until(() => fixture.sockets.opened.length === 2);

  assert.deepEqual(views, [{ segments: 4, normals: 'facet', encoding: 'quantised', positionBits: 12, normalBits: 8 }]);
  assert.equal(fixture.stream.request.view?.segments, 4);
  assert.deepEqual(fixture.said, ['Too large for the server: 4.49 GB of memory are wanted for the view, and 43.6 MB are free.']);
  fixture.stream.end(tooLarge);
  await until(() => fixture.sockets.opened.length === 3);
  assert.equal(fixture.said.length, 1);
  fixture.session.close();
});

test('a server that did not answer in time is left alone for the longest pause', async (t) => {
  const fixture = new SessionFixture({ backOff: { firstMs: 1, lastMs: HOUR } });
  t.after(() => fixture.session.close());
  fixture.stream.hello();
  fixture.stream.end(unavailable());
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello();
  const pauses = t.mock.method(globalThis, 'setTimeout');
  fixture.stream.end(new ServerError(Code.DeadlineExceeded, 'NO_ANSWER', 'in vain'));

  assert.ok(pauses.mock.calls.some(({ arguments: [, ms] }) => ms === HOUR));
  assert.equal(fixture.session.status.text, 'In vain. Trying again …');
});

test('goaway says when to come back', async (t) => {
  const fixture = await SessionFixture.live();
  t.after(() => fixture.session.close());
  fixture.stream.event({ case: 'goaway', value: { retryAfter: { seconds: 3600n, nanos: 0 } } });
  const pauses = t.mock.method(globalThis, 'setTimeout');
  fixture.stream.end();

  assert.ok(pauses.mock.calls.some(({ arguments: [, ms] }) => ms === HOUR));
});

test('a server that has lost the scene gets mesh and lattice again from this browser, under the same id', async () => {
  const fixture = await SessionFixture.live();
  fixture.session.apply(move);
  fixture.server.bootId = 'boot-2';
  fixture.server.meshes.clear();

  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello('boot-2');

  const made = fixture.server.scenes.get('scene-0001')!;
  const { source } = made.lattices[0];
  assert.deepEqual([...fixture.server.meshes.get('mesh-1')!], [1, 2, 3]);
  assert.equal(source.case === 'lattice' && source.value.controlPoints[3], 0.75);
  assert.equal(fixture.session.status.state, 'restored');
  assert.match(fixture.session.status.text, /restarted/);
  assert.equal(fixture.stream.edits.length, 0);  // the lattice held what was in flight
  assert.equal(fixture.stream.request.resumeToken!.length, 0);
  fixture.session.close();
});

test('a page that is opened after the restart restores the scene from what an earlier one saved', async () => {
  const earlier = await SessionFixture.live();
  earlier.session.close();
  const fixture = new SessionFixture({ store: earlier.store });
  fixture.server.bootId = 'boot-2';
  fixture.server.meshes.clear();

  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello('boot-2');
  fixture.state();
  await fixture.session.ready;
  fixture.server.deleted = true;
  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.session.status.state === 'failed');  // and what is deleted on this run stays deleted

  assert.deepEqual([...fixture.server.meshes.get('mesh-1')!], [1, 2, 3]);
  assert.deepEqual(fixture.states, ['restored', 'failed']);
  fixture.session.close();
});

test('a mesh that this browser has is not read back, one of another window is; the former restores the scene', async () => {
  const store = new MemorySceneStore();
  await store.saveMesh(storedMesh('mesh-1', { name: 'cube' }, new Blob([Uint8Array.of(1, 2, 3)])));
  const uploader = await SessionFixture.live({ store });
  const other = await SessionFixture.live();
  await until(() => other.store.saves === 2);
  assert.deepEqual([uploader.server.downloads, other.server.downloads], [0, 1]);
  other.session.close();

  uploader.server.bootId = 'boot-2';
  uploader.server.meshes.clear();
  uploader.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => uploader.sockets.opened.length === 2);

  assert.deepEqual([...uploader.server.meshes.get('mesh-1')!], [1, 2, 3]);
  assert.deepEqual(uploader.notKept, []);
  uploader.session.close();
});

test('a scene that the browser does not keep is told of once, in words; the page restores it still', async () => {
  const store = new MemorySceneStore();
  store.refusal = new Error('the browser has no room left for it');
  const fixture = await SessionFixture.live({ store });
  await until(() => fixture.notKept.length === 1);
  fixture.delta(1n, [1], [0.75, 0, 0], 'another');
  await until(() => store.saves === 3);  // the scene, its mesh, and the scene with what has changed

  fixture.server.bootId = 'boot-2';
  fixture.server.meshes.clear();
  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.sockets.opened.length === 2);

  assert.deepEqual(fixture.notKept, ['If the server is restarted, this scene may be lost: the browser has no room left for it.']);
  assert.deepEqual([...fixture.server.meshes.get('mesh-1')!], [1, 2, 3]);
  fixture.session.close();
});

test('a mesh that is too large to read back is told of; what failed for a lost connection is read back with the next', async () => {
  const large = new SessionFixture();
  large.server.meshBytes = 300_000_000n;
  large.stream.hello();
  large.state();
  await until(() => large.notKept.length === 1);
  assert.match(large.notKept[0], /may be lost: its mesh, 300 MB, was uploaded elsewhere and is too large to fetch\.$/);
  assert.equal(large.server.downloads, 0);
  large.session.close();

  const cut = new SessionFixture();
  cut.server.downloadRefusal = new ConnectError('reset', Code.Unavailable);
  cut.stream.hello();
  cut.state();
  await until(() => cut.server.downloads === 1);
  cut.server.downloadRefusal = undefined;
  cut.stream.end(unavailable());
  await until(() => cut.sockets.opened.length === 2);
  cut.stream.hello();
  await until(async () => Boolean(await cut.store.mesh('mesh-1')));
  assert.deepEqual(cut.notKept, []);
  cut.session.close();
});

test('where the browser gives no database, saving says so, and the page has what was saved', async () => {
  const store = new IndexedSceneStore();  // Node has none
  const mesh = storedMesh('mesh-1', { name: 'cube' }, new Blob([Uint8Array.of(1, 2, 3)]));

  await assert.rejects(store.saveMesh(mesh), /^Error: the browser keeps nothing for this page, as in some private windows/);

  assert.equal((await store.mesh('mesh-1'))?.content, mesh.content);
  assert.equal(await store.mesh('mesh-2'), undefined);
  await assert.rejects(store.saveCompanions('mesh-1', []), /^Error: the browser keeps nothing for this page/);
  assert.deepEqual(await store.companions('mesh-1'), []);
});

test('without the mesh\'s bytes nothing is restored, in words', async () => {
  const fixture = await SessionFixture.live();
  fixture.server.bootId = 'boot-2';
  fixture.server.meshes.clear();
  fixture.store.mesh = async () => undefined;
  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.session.status.state === 'failed');

  assert.match(fixture.session.status.text, /no copy of the mesh/);
  fixture.session.close();
});

test('a scene that somebody deleted stays deleted, in words', async () => {
  const fixture = await SessionFixture.live();
  fixture.server.deleted = true;
  fixture.stream.end(new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001'));
  await until(() => fixture.session.status.state === 'failed');

  assert.equal(fixture.session.status.text, 'No scene scene-0001.');
  assert.equal(fixture.server.scenes.size, 0);
  assert.equal(fixture.sockets.opened.length, 1);
  fixture.session.close();
});

test('a token that may only look loses presence and goes on; one that is unknown fails in words', async () => {
  const fixture = await SessionFixture.live({ features: [Feature.PRESENCE], name: 'Ada' });
  fixture.session.announce(Uint32Array.of(4, 5));
  await until(() => fixture.stream.presences.length === 1);
  assert.deepEqual(fixture.stream.presences[0].selectedIndices, [4, 5]);
  assert.equal(fixture.stream.presences[0].name, 'Ada');

  fixture.stream.end(new ServerError(Code.PermissionDenied, 'PERMISSION_DENIED', 'role edit'));
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello();
  fixture.session.announce(Uint32Array.of(4));
  fixture.stream.end(new ServerError(Code.Unauthenticated, 'UNAUTHENTICATED', 'who are you'));
  await until(() => fixture.session.status.state === 'failed');

  assert.equal(fixture.stream.presences.length, 0);
  assert.match(fixture.session.status.text, /#token=/);
  fixture.session.close();
});

test('others appear with what they have selected, and vanish when their stream does', async () => {
  const fixture = await SessionFixture.live();
  const seen: string[] = [];
  fixture.session.on('presence', (others) => seen.push([...others].map(([id, { selected }]) => `${id} ${selected}`).join()));

  fixture.stream.event({ case: 'presence', value: { editorId: 'b', name: 'Bo', colour: 255, selectedIndices: [1, 2] } });
  fixture.stream.event({ case: 'presence', value: { editorId: fixture.session.editorId, selectedIndices: [9] } });

  assert.deepEqual(seen, ['b 1,2']);
  fixture.stream.end();
  await until(() => fixture.sockets.opened.length === 2);
  fixture.stream.hello();
  assert.deepEqual(seen, ['b 1,2', '']);  // who left meanwhile is not told of: all come anew
  fixture.session.close();
});

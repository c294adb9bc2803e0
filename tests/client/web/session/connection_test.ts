// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lost streams and restarted servers, in cases that no test in a browser reaches.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Code, ConnectError } from '@connectrpc/connect';
import { Feature } from 'latticed/v1/server_pb';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import { CompanionStore } from '@src/intake/companion_store';
import { SceneConnection } from '@src/session/scene_connection';
import type { ViewRequest } from '@src/session/scene_session';
import { ServerError } from '@src/wire/server_error';
import { inWords } from '@src/wire/words';
import { noScene, SessionFixture, unavailable, until } from '../support/session_fixture';

const HOUR = 3_600_000;
const FIRST_EVENT_MS = 15_000; // the silence that a stream may begin with

test('where twice no WebSocket opens but calls pass, gRPC-Web is used; where that is lost, the socket is tried again', async (t) => {
  const fixture = new SessionFixture(t);
  const { server, sockets, watches } = fixture;
  await fixture.reconnect(unavailable);
  await fixture.lose(unavailable); // does not count: this stream had opened
  server.refusal = new ConnectError('down', Code.Unavailable);
  await fixture.lose(unavailable);
  server.refusal = undefined;
  await fixture.lose(unavailable);
  assert.equal(watches.opened.length, 0);
  fixture.stream.end(unavailable);
  await until(() => watches.opened.length === 1);

  watches.newest.hello();
  assert.equal(fixture.session.status.state, 'live');
  const { deadlines } = server;  // they end calls on a dead connection
  assert.ok(deadlines.length > 0 && deadlines.every((ms) => ms > 0 && ms <= 5000), `${deadlines}`);
  const { length } = sockets.opened;
  watches.newest.end(unavailable);
  await until(() => sockets.opened.length === length + 1);
});

test('a pick is waited for 10 seconds at most, and then said in words to have failed', async (t) => {
  const fixture = await SessionFixture.live(t, { features: [Feature.PICK] });

  const said = await fixture.session.pick([0, 0, 1], [0, 0, -1]).then(() => 'answered', inWords);

  assert.equal(said, 'The server did not answer in time.');
  const [ms] = fixture.server.deadlines;
  assert.ok(ms > 0 && ms <= 10_000, `${ms}`);
});

test('when the network is back, or the page is looked at, no pause is waited for', async (t) => {
  const fixture = new SessionFixture(t, { backOff: { firstMs: HOUR, lastMs: HOUR } });
  for (const [count, wake] of (['networkBack', 'seen'] as const).entries()) {
    fixture.stream.hello();
    fixture.awake!.seen();
    assert.equal(fixture.sockets.opened.length, count + 1);  // a live stream is kept
    fixture.stream.end(unavailable);
    fixture.awake![wake]();
    assert.equal(fixture.sockets.opened.length, count + 2);
  }
  fixture.session.close();
  assert.ok(fixture.awake === undefined);
});

test('for 30 s pauses stay below a second, then they grow to ten', (t) => {
  let now = 0;
  t.mock.method(performance, 'now', () => now);
  const pauses: { readonly at: number; readonly ms: number }[] = [];
  let goOn = (): void => {};
  t.mock.method(globalThis, 'setTimeout', (wake: () => void, ms: number) => {
    if (ms === FIRST_EVENT_MS) return;
    pauses.push({ at: now, ms });
    goOn = wake;
  });
  const down = new ServerError(Code.Unavailable, 'STORE', 'down');
  let end: (error: ServerError) => void = () => {};
  const connection = new SceneConnection([(_, handler) => {
    end = handler.end;
    return { send: () => {}, close: () => {} };
  }], {
    request: () => ({}), opened: () => {}, event: () => {}, retrying: () => {},
    ended: () => Promise.resolve('stop'), probe: () => Promise.resolve(undefined),
  });

  connection.open();
  while (now < 90_000) {
    end(down);
    now += pauses.at(-1)!.ms;
    goOn();
  }
  connection.close();

  const [soon, later] = [pauses.filter(({ at }) => at < 30_000), pauses.filter(({ at }) => at >= 30_000)];
  assert.ok(soon.length >= 30 && soon.every(({ ms }) => ms <= 1000), JSON.stringify(soon));
  assert.ok(later.length >= 6 && later.every(({ ms }) => ms >= 5000 && ms <= 10_000), JSON.stringify(later));
});

test('a socket that is refused for its token waits for another one, and asks for it', async (t) => {
  const fixture = new SessionFixture(t);
  const { client } = fixture.server;
  fixture.server.refusal = new ConnectError('unknown token', Code.Unauthenticated);
  fixture.stream.end(unavailable);
  await until(() => fixture.session.status.state === 'token');

  assert.equal(fixture.session.status.text, 'The server needs a token.');
  assert.equal(fixture.sockets.opened.length, 1);
  client.useToken('another wrong one');
  assert.equal(fixture.sockets.opened.length, 2);
  fixture.stream.end(unavailable);
  await until(() => fixture.session.status.state === 'token');
  assert.match(fixture.session.status.text, /^The token of this page has expired, or is not valid\./);
  fixture.server.refusal = undefined;
  client.useToken('right');
  fixture.stream.hello();
  fixture.state();
  await fixture.session.ready;
  assert.equal(fixture.session.status.state, 'live');
});

test('edits wait while a token is asked for, and are sent with the next one, in order, once each', async (t) => {
  const fixture = await SessionFixture.live(t);
  const edit = (): void => fixture.session.undo();
  const sequences = (): bigint[] => fixture.stream.edits.map(({ sequence }) => sequence);
  edit(); // in flight
  edit(); // waits
  fixture.stream.end(new ServerError(Code.Unauthenticated, 'UNAUTHENTICATED', "the token has expired ('exp')"));
  assert.equal(fixture.session.status.state, 'token');
  edit();
  await new Promise((resolve) => setImmediate(resolve));
  assert.equal(fixture.sockets.opened.length, 1); // nothing is tried with the old token

  fixture.server.client.useToken('new');
  fixture.stream.hello();

  assert.deepEqual(sequences(), [1n]);
  for (const sequence of [1n, 2n, 3n]) fixture.accept(sequence, sequence);
  assert.deepEqual(sequences(), [1n, 2n, 3n]);
  assert.deepEqual(fixture.said, []);
  fixture.session.close();
  const { length } = fixture.sockets.opened;
  fixture.server.client.useToken('later');
  assert.equal(fixture.sockets.opened.length, length);
});

test('another token, come while a call asks whether the server is there, is not overtaken by the answer', async (t) => {
  const fixture = await SessionFixture.live(t);
  fixture.server.refusal = new ConnectError('unknown token', Code.Unauthenticated);
  await fixture.lose(unavailable);
  fixture.stream.end(unavailable); // a call is made with the old token
  fixture.server.client.useToken('new');
  fixture.stream.hello();
  await until(() => fixture.server.deadlines.length > 0);
  await new Promise((resolve) => setTimeout(resolve, 10));

  fixture.session.undo();

  assert.equal(fixture.session.status.state, 'live');
  assert.equal(fixture.stream.edits.length, 1);
});

test('a view that is too large for the server is taken back to the one before, in words', async (t) => {
  const fixture = await SessionFixture.live(t);
  const views: ViewRequest[] = [];
  fixture.session.on('view', (view) => views.push(view));
  const view = { segments: 4, normals: NormalMode.FACET, encoding: Encoding.QUANTISED, positionBits: 12, normalBits: 8 };
  fixture.stream.event({ case: 'updateBegin', value: { updateId: 1n, view } });
  fixture.stream.event({ case: 'updateEnd', value: { updateId: 1n, fullDetail: true } });
  await until(() => fixture.stream.controls.length === 1);

  fixture.session.setView({ segments: 32 });
  const tooLarge = new ServerError(Code.ResourceExhausted, 'OUT_OF_MEMORY', 'the view needs 4491922512 bytes, 43616405 are free');
  await fixture.lose(tooLarge);

  const granted = { segments: 4, tolerance: 0, maxPoints: 0, normals: 'facet', encoding: 'quantised', positionBits: 12, normalBits: 8 };
  assert.deepEqual(views, [granted]);
  assert.equal(fixture.stream.request.view?.segments, 4);
  assert.deepEqual(fixture.said, ['Too large for the server: 4.49 GB of memory are needed for the view, and 43.6 MB are free.']);
  await fixture.lose(tooLarge);
  assert.equal(fixture.said.length, 1);
});

test('where the server has no memory for the most points of a tolerance, fewer are asked for; where it has no tolerance, segments are', async (t) => {
  const fixture = await SessionFixture.live(t);
  const views: ViewRequest[] = [];
  fixture.session.on('view', (view) => views.push(view));
  fixture.session.setView({ segments: 32, tolerance: 0.25, maxPoints: 100_000 });

  await fixture.lose(new ServerError(Code.ResourceExhausted, 'OUT_OF_MEMORY', 'the view needs 4491922512 bytes, 43616405 are free'));
  const asked = fixture.stream.request.view!;
  assert.deepEqual([asked.segments, asked.tolerance], [10, 0.25]);
  assert.deepEqual(views, []);
  await fixture.lose(new ServerError(Code.InvalidArgument, 'UNSUPPORTED', 'view.tolerance: this pipeline has none on these devices'));

  const { segments, tolerance, maxPoints } = fixture.stream.request.view!;
  assert.deepEqual([segments, tolerance, maxPoints], [10, 0, 0n]);
  assert.deepEqual(views, [{ tolerance: 0 }]);
  assert.equal(fixture.said.length, 1);
});

test('a scene that says no for its vertex weights, as one of an earlier server, is shown by segments', async (t) => {
  for (const view of [{ segments: 32, tolerance: 0.25, maxPoints: 100_000 }, { encoding: 'patches' }] as ViewRequest[]) {
    const fixture = await SessionFixture.live(t);
    const views: ViewRequest[] = [];
    fixture.session.on('view', (granted) => views.push(granted));
    fixture.session.setView(view);

    await fixture.lose(new ServerError(Code.FailedPrecondition, 'VERTEX_WEIGHTS', 'the scene has vertex weights'));

    assert.equal(fixture.stream.request.view!.tolerance, 0);
    assert.equal(views.length, 1);
    assert.notEqual(views[0]!.encoding, 'patches');
  }
});

test('a server that did not answer in time is left alone for the longest pause; one that goes away says for how long', async (t) => {
  const pauses = t.mock.method(globalThis, 'setTimeout');
  const pausesAnHour = (): boolean => pauses.mock.calls.some(({ arguments: [, ms] }) => ms === HOUR);
  const silent = new SessionFixture(t, { backOff: { firstMs: 1, lastMs: HOUR } });
  silent.stream.hello();
  await silent.reconnect(unavailable);
  pauses.mock.resetCalls();
  silent.stream.end(new ServerError(Code.DeadlineExceeded, 'NO_ANSWER', 'in vain'));
  assert.ok(pausesAnHour());
  assert.equal(silent.session.status.text, 'In vain. Trying again …');

  const leaving = await SessionFixture.live(t);
  leaving.stream.event({ case: 'goaway', value: { retryAfter: { seconds: 3600n, nanos: 0 } } });
  pauses.mock.resetCalls();
  leaving.stream.end();
  assert.ok(pausesAnHour());
});

test('a stream that is silent for two and a half heartbeats is given up; within an update after twice the time, then four times', async (t) => {
  const waits = t.mock.method(globalThis, 'setTimeout');
  const waited = (ms: number): boolean => waits.mock.calls.some(({ arguments: [, asked] }) => asked === ms);
  const fixture = new SessionFixture(t);
  const silent = async (): Promise<void> => {
    waits.mock.resetCalls();
    const { length } = fixture.sockets.opened;
    fixture.stream.hello(undefined, 24);
    await until(() => fixture.sockets.opened.length > length);
  };

  await silent();
  assert.ok(waited(120) && !waited(60));
  await silent();
  assert.ok(waited(240) && !waited(120));
  fixture.stream.event({ case: 'updateEnd', value: {} });
  await silent();
  assert.ok(waited(60));
  fixture.stream.hello(undefined, 24);
  fixture.stream.event({ case: 'updateEnd', value: {} });
  const { length } = fixture.sockets.opened;
  await until(() => fixture.sockets.opened.length > length);  // nothing large was under way: a cut, and no slow line
  await silent();
  assert.ok(waited(120) && !waited(240));
  assert.equal(fixture.session.status.state, 'retrying');
});

test('a page that was busy takes what came meanwhile, and is not silent', async (t) => {
  const fixture = await SessionFixture.live(t);
  fixture.stream.hello(undefined, 100);
  const came = new Promise<void>((resolve) => setTimeout(() => {
    fixture.stream.event({ case: 'heartbeat', value: {} });
    resolve();
  }, 251));
  const end = performance.now() + 300;
  while (performance.now() < end); // timers run late, that of the silence before the event

  await came;
  assert.equal(fixture.session.status.state, 'live');
  assert.equal(fixture.sockets.opened.length, 1);
});

test('where the browser gives no database, saving says so, and nothing is there', async () => {
  const store = new CompanionStore();  // Node has no database

  await assert.rejects(store.save('mesh-1', []), /^Error: the browser keeps nothing for this page, as in some private windows/);

  assert.deepEqual(await store.of('mesh-1'), []);
});

test('a scene that the server has no longer is not asked for again, and the page says why', async (t) => {
  const inMemory = /no longer has this scene: it was restarted and keeps nothing, or somebody deleted it\. The lattice can still be saved here\.$/;
  for (const [durable, words] of [[true, /no longer has this scene: somebody deleted it, or nobody used it for too long\. The lattice can still be saved here\.$/], [false, inMemory]] as const) {
    const fixture = await SessionFixture.live(t, { durable });
    fixture.stream.end(noScene);
    await until(() => fixture.session.status.state === 'failed');

    assert.match(fixture.session.status.text, words);
    assert.equal(fixture.sockets.opened.length, 1);
  }
  const never = new SessionFixture(t);
  never.stream.end(noScene);
  await assert.rejects(never.session.ready, /^Error: No scene scene-0001\.$/);
});

test('a server that keeps scenes only in memory is said to', async (t) => {
  assert.equal((await SessionFixture.live(t)).session.status.text, 'Connected.');
  const { session } = await SessionFixture.live(t, { durable: false });
  assert.equal(session.status.text, 'Connected. This server keeps scenes only in memory.');
});

test('who has left while the stream was lost is not shown on the next one', async (t) => {
  const fixture = await SessionFixture.live(t);
  const seen: string[] = [];
  fixture.session.on('presence', (others) => seen.push([...others].map(([id, { selected }]) => `${id} ${selected}`).join()));
  fixture.stream.event({ case: 'presence', value: { editorId: 'b', name: 'Bo', colour: 255, selectedIndices: [1, 2] } });
  fixture.stream.event({ case: 'presence', value: { editorId: fixture.session.editorId, selectedIndices: [9] } });

  await fixture.reconnect();

  assert.deepEqual(seen, ['b 1,2', '']);
});

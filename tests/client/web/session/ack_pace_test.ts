// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which updates a session acknowledges. An acknowledgement lets the server begin another update.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { AckPace } from '@src/session/ack_pace';
import { SessionFixture, until } from '../support/session_fixture';

const acksOf = ({ stream }: SessionFixture) => stream.controls.map(({ ackedUpdateId }) => ackedUpdateId);

test('after an update that replaced an unseen one, each is acknowledged with the next, until two at once are tried again', () => {
  const pace = new AckPace();
  pace.opened();
  assert.equal(pace.take(1n, undefined), 1n);

  assert.equal(pace.take(3n, 2n), 2n);
  const last = 3n + BigInt(AckPace.ALONE);
  for (let id = 4n; id < last; ++id) assert.equal(pace.take(id, undefined), id - 1n);
  assert.equal(pace.take(last, undefined), last);

  pace.take(last + 2n, last + 1n);
  pace.opened(); // the updates of a new stream are numbered from 1
  assert.equal(pace.take(1n, undefined), 1n);
});

test('an update of a lost stream that was still being decoded is shown, and the new stream hears nothing of its number', async (t) => {
  const fixture = await SessionFixture.live(t, { decodesAtOnce: false });
  let shown = 0;
  fixture.session.on('update', () => ++shown);
  fixture.sendTriangle(57n);
  await fixture.reconnect();
  await until(async () => (await fixture.worker.work(), shown === 1));
  assert.deepEqual(acksOf(fixture), []);

  fixture.sendTriangle(1n);
  await until(async () => (await fixture.worker.work(), shown === 2));
  assert.deepEqual(acksOf(fixture), [1n]);
});

test('where what came could not be read all is asked for anew, whatever was still being decoded', async (t) => {
  // The pause before the next stream is longer than the decoding.
  const fixture = await SessionFixture.live(t, { decodesAtOnce: false, backOff: { firstMs: 1000, lastMs: 1000 } });
  const { sockets, worker } = fixture;
  let shown = 0;
  fixture.session.on('update', () => ++shown);
  fixture.sendTriangle(57n);
  fixture.stream.event({ case: 'updateBegin', value: { updateId: 58n } });
  fixture.stream.event({ case: 'chunks', value: { updateId: 58n, topologyId: 'no such', chunks: [{ index: 0 }] } });
  assert.match(fixture.session.status.text, /cannot be shown/);
  await until(async () => (await worker.work(), shown === 1));
  assert.equal(sockets.opened.length, 1);
  await until(() => sockets.opened.length === 2);
  assert.deepEqual([...sockets.newest.request.resumeToken!], []);

  fixture.stream.hello();
  fixture.sendTriangle(1n);
  await until(async () => (await worker.work(), acksOf(fixture).length > 0));
  await fixture.reconnect();
  assert.deepEqual([...sockets.newest.request.resumeToken!], [1]);
});

test('where the first update of the new stream takes its place, that one is acknowledged', async (t) => {
  const fixture = await SessionFixture.live(t, { decodesAtOnce: false });
  fixture.sendTriangle(57n);
  await fixture.reconnect();
  fixture.sendTriangle(1n);

  await until(async () => (await fixture.worker.work(), acksOf(fixture).length > 0));
  assert.deepEqual(acksOf(fixture), [1n]);
});

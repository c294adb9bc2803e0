// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a session acknowledges, by which the server begins the next update.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { Code } from '@connectrpc/connect';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import { AckPace } from '@src/session/ack_pace';
import { ServerError } from '@src/wire/server_error';
import { SessionFixture, until, type Options } from './support/session_fixture';

/** A live session whose server sends updates. */
class Watched {
  private constructor(readonly fixture: SessionFixture) {}

  static async live(t: TestContext, options: Options = {}): Promise<Watched> {
    const watched = new Watched(await SessionFixture.live(options));
    t.after(() => watched.fixture.session.close());
    return watched;
  }

  get acks(): (bigint | undefined)[] {
    return this.fixture.stream.controls.map(({ ackedUpdateId }) => ackedUpdateId);
  }

  /** The connection is lost, and the next one is there. */
  async reconnect(): Promise<void> {
    const { sockets, stream } = this.fixture;
    const before = sockets.opened.length;
    stream.end(new ServerError(Code.Unavailable, '', 'the connection is lost'));
    await until(() => sockets.opened.length === before + 1);
    this.fixture.stream.hello();
  }

  /** Sends a whole update of one chunk, of one triangle, after which the stream could be resumed by its number. */
  sendTriangle(updateId: bigint): void {
    const { stream } = this.fixture;
    const pattern = { points: [1, 0, 0, 0, 1, 0, 0, 0, 1], triangles: [0, 1, 2] };
    stream.event({ case: 'topology', value: {
      topologyId: 't', patchCount: 1n, pointCount: 3n, triangleCount: 1n, segments: 1, chunkRuns: [{ chunkCount: 1, patchesPerChunk: 1 }], pattern } });
    stream.event({ case: 'quantisation', value: { quantisationId: 1n, origin: { x: 0, y: 0, z: 0 }, step: 1, bits: 12 } });
    stream.event({ case: 'updateBegin', value: { updateId, view: { encoding: Encoding.QUANTISED, normals: NormalMode.NONE } } });
    stream.event({ case: 'chunks', value: {
      updateId, topologyId: 't', quantisationId: 1n, chunks: [{ index: 0, data: new Uint8Array(18) }] } });
    stream.event({ case: 'updateEnd', value: { updateId, resumeToken: Uint8Array.of(Number(updateId)) } });
  }

  /** Sends whole updates, each before the one ahead of it can be decoded, and returns what is then acknowledged. */
  async send(...ids: bigint[]): Promise<bigint | undefined> {
    const before = this.acks.length;
    for (const updateId of ids) {
      this.fixture.stream.event({ case: 'updateBegin', value: { updateId } });
      this.fixture.stream.event({ case: 'updateEnd', value: { updateId } });
    }
    await until(() => this.acks.length > before);
    return this.acks.at(-1);
  }
}

test('updates that go up in the next one unseen are not asked for: one at a time comes, until two are tried again', async (t) => {
  const watched = await Watched.live(t);
  assert.equal(await watched.send(1n), 1n);

  assert.equal(await watched.send(2n, 3n), 2n);
  for (let id = 4n; id < 3n + BigInt(AckPace.ALONE); ++id) assert.equal(await watched.send(id), id - 1n);

  const last = 3n + BigInt(AckPace.ALONE);
  assert.equal(await watched.send(last), last);
  assert.equal(await watched.send(last + 1n), last + 1n);
});

test('on a new stream, whose updates have other numbers, two may come again', async (t) => {
  const watched = await Watched.live(t);
  assert.equal(await watched.send(1n, 2n, 3n), 2n);
  await watched.reconnect();

  assert.equal(await watched.send(1n), 1n);
  assert.equal(await watched.send(2n), 2n);
});

test('an update of a lost stream that was still being decoded is shown, and the new stream hears nothing of its number', async (t) => {
  const watched = await Watched.live(t, { decodesAtOnce: false });
  let shown = 0;
  watched.fixture.session.on('update', () => ++shown);
  watched.sendTriangle(57n);
  await watched.reconnect();
  await until(async () => (await watched.fixture.worker.work(), shown === 1));
  assert.deepEqual(watched.acks, []);

  watched.sendTriangle(1n);
  await until(async () => (await watched.fixture.worker.work(), shown === 2));
  assert.deepEqual(watched.acks, [1n]);
});

test('where what came could not be read all is asked for anew, whatever was still being decoded', async (t) => {
  const watched = await Watched.live(t, { decodesAtOnce: false, backOff: { firstMs: 1000, lastMs: 1000 } }); // it is decoded before
  const { sockets, worker } = watched.fixture;
  let shown = 0;
  watched.fixture.session.on('update', () => ++shown);
  watched.sendTriangle(57n);
  watched.fixture.stream.event({ case: 'updateBegin', value: { updateId: 58n } });
  watched.fixture.stream.event({ case: 'chunks', value: { updateId: 58n, topologyId: 'no such', chunks: [{ index: 0 }] } });
  assert.match(watched.fixture.session.status.text, /cannot be shown/);
  await until(async () => (await worker.work(), shown === 1));
  assert.equal(sockets.opened.length, 1);
  await until(() => sockets.opened.length === 2);
  assert.deepEqual([...sockets.newest.request.resumeToken!], []);

  watched.fixture.stream.hello();
  watched.sendTriangle(1n);
  await until(async () => (await worker.work(), watched.acks.length > 0));
  await watched.reconnect();
  assert.deepEqual([...sockets.newest.request.resumeToken!], [1]);
});

test('where the first update of the new stream takes its place, that one is acknowledged', async (t) => {
  const watched = await Watched.live(t, { decodesAtOnce: false });
  watched.sendTriangle(57n);
  await watched.reconnect();
  watched.sendTriangle(1n);

  await until(async () => (await watched.fixture.worker.work(), watched.acks.length > 0));
  assert.deepEqual(watched.acks, [1n]);
});

test('a session says how many updates it takes unacknowledged', async (t) => {
  const watched = await Watched.live(t);
  assert.equal(watched.fixture.stream.request.maxUnackedUpdates, AckPace.AT_ONCE);
});

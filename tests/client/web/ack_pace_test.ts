// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a session acknowledges, by which the server begins the next update.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { Code } from '@connectrpc/connect';
import { AckPace } from '@src/session/ack_pace';
import { ServerError } from '@src/wire/server_error';
import { SessionFixture, until } from './support/session_fixture';

/** A live session whose server sends updates. */
class Watched {
  private constructor(readonly fixture: SessionFixture) {}

  static async live(t: TestContext): Promise<Watched> {
    const watched = new Watched(await SessionFixture.live());
    t.after(() => watched.fixture.session.close());
    return watched;
  }

  get acks(): (bigint | undefined)[] {
    return this.fixture.stream.controls.map(({ ackedUpdateId }) => ackedUpdateId);
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
  watched.fixture.stream.end(new ServerError(Code.Unavailable, '', 'the connection is lost'));
  await until(() => watched.fixture.sockets.opened.length === 2);
  watched.fixture.stream.hello();

  assert.equal(await watched.send(1n), 1n);
  assert.equal(await watched.send(2n), 2n);
});

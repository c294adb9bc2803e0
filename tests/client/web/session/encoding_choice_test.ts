// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How points come where the person leaves it to the page.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { Code, ConnectError } from '@connectrpc/connect';
import { Encoding } from 'latticed/v1/view_pb';
import { DecodePool } from '@src/decode/decode_pool';
import { chooseEncoding } from '@src/session/encoding_choice';
import type { UpdateInfo } from '@src/session/scene_session';
import { FakeServer } from '../support/fake_server';
import { SessionFixture, until } from '../support/session_fixture';

/** A live session that leaves the encoding open and has its first update, where a worker takes so long for a point of Draco. */
async function open(t: TestContext, server: FakeServer, dracoNs: number | undefined, hasOwnDecoder = true): Promise<SessionFixture> {
  t.mock.getter(DecodePool.prototype, 'dracoNs', () => dracoNs);
  const fixture = await SessionFixture.live(t, { server });
  Object.assign(fixture.pool, { hasOwnDecoder });
  fixture.session.setView({ encoding: 'auto' });
  assert.deepEqual(asked(fixture), [Encoding.DRACO_POINTS]);
  await update(fixture, 1n);
  return fixture;
}

function asked({ stream }: SessionFixture): Encoding[] {
  return stream.controls.flatMap(({ view }) => (view ? [view.encoding] : []));
}

async function update(fixture: SessionFixture, id: bigint): Promise<UpdateInfo> {
  const done = new Promise<UpdateInfo>((resolve) => fixture.session.on('update', resolve));
  fixture.sendTriangle(id);
  return done;
}

/** The reason that updates tell, as soon as there is one. */
async function reason(fixture: SessionFixture): Promise<string> {
  for (let id = 2n; ; ++id) {
    const { chosen } = await update(fixture, id);
    if (chosen !== undefined) return chosen;
    await new Promise((resolve) => setTimeout(resolve, 1));
  }
}

test('the time of more bytes on the line is weighed against that of decoding', () => {
  assert.deepEqual(chooseEncoding(100e6, 18, 4), {
    encoding: 'meshopt', reason: "meshopt's 0.2 bytes more a point take 2.0 ns at 100 MB/s, decoding saves 3.0 ns",
  });
  assert.deepEqual(chooseEncoding(50e6, 18, 4), {
    encoding: 'draco', reason: "meshopt's 0.2 bytes more a point take 4.0 ns at 50.0 MB/s, decoding saves 3.0 ns",
  });
});

test('points come by Draco, and by meshopt once that is faster by what was measured, also after a break', async (t) => {
  const server = new FakeServer();
  const fixture = await open(t, server, 1000);
  await until(() => asked(fixture).length === 2);
  assert.deepEqual(asked(fixture), [Encoding.DRACO_POINTS, Encoding.MESHOPT]);
  assert.deepEqual(server.probes, [0, 8192, 262144, 262144]);
  assert.match(await reason(fixture), /^meshopt: meshopt's 0.2 bytes more a point take /);
  await fixture.lose();
  assert.equal(fixture.stream.request.view?.encoding, Encoding.MESHOPT);
  assert.equal(fixture.session.askedView.encoding, 'auto');
});

test('a slow line keeps Draco, and is not kept busy by large probes', async (t) => {
  const server = new FakeServer();
  server.msPerProbeByte = 0.01;
  const fixture = await open(t, server, 1000);
  assert.match(await reason(fixture), /^draco: meshopt's 0.2 bytes more a point take /);
  assert.deepEqual(server.probes, [0, 8192]);
  assert.deepEqual(asked(fixture), [Encoding.DRACO_POINTS]);
});

test('Draco stays where the server or the browser lacks meshopt, and where nothing can be measured', async (t) => {
  const old = new FakeServer();
  old.encodings = [Encoding.DRACO_POINTS];
  assert.equal(await reason(await open(t, old, 1000)), 'draco: the server has no meshopt');
  const server = new FakeServer();
  assert.equal(await reason(await open(t, server, 1000, false)), 'draco: this browser has no WebAssembly SIMD');
  const fixture = await open(t, server, undefined);
  assert.equal((await update(fixture, 2n)).chosen, undefined);
  assert.deepEqual(server.probes, []);
  t.mock.getter(DecodePool.prototype, 'dracoNs', () => 1000);
  server.refusal = new ConnectError('too busy', Code.Unavailable);
  assert.equal(await reason(fixture), 'draco: the line could not be measured');
});

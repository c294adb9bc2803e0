// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene that somebody made again under the same id, on a server that kept nothing. Its history begins anew.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import type { LatticeEdit } from '@src/session/edits/lattice_edit';
import { SessionFixture, cubeLattice } from '../../support/session_fixture';

const move = (x: number): LatticeEdit => ({ kind: 'move', indices: Uint32Array.of(1), offset: [x, 0, 0] });

/** A window at revision 7, whose last edit is answered but not yet in its lattice. Then its stream is lost. */
async function lost(t: TestContext): Promise<SessionFixture> {
  const fixture = await SessionFixture.live(t);
  fixture.state(cubeLattice(), 1n, 7n);
  fixture.session.apply(move(0.25));
  fixture.accept(1n, 8n);
  await fixture.lose();
  return fixture;
}

test('what was answered before is neither shown nor undone', async (t) => {
  const fixture = await lost(t);
  assert.equal(fixture.x(1), 0.75);
  assert.ok(fixture.session.canUndo);

  fixture.stream.hello(0n);
  fixture.state();

  assert.equal(fixture.x(1), 0.5);
  assert.ok(!fixture.session.canUndo);
  assert.ok(fixture.session.isAt(0));
  assert.deepEqual(fixture.said, []);
});

test('edits that were made meanwhile are for the other scene: they are dropped, in words', async (t) => {
  const fixture = await lost(t);
  fixture.session.apply(move(0.125)); // would be in flight
  fixture.session.apply(move(0.0625));
  fixture.session.gesture().update(move(1));

  fixture.stream.hello(0n);
  fixture.state();

  assert.deepEqual(fixture.stream.edits, []);
  assert.deepEqual(fixture.said, ['The scene was made again meanwhile, so unsent edits were dropped.']);
  assert.equal(fixture.x(1), 0.5);
  fixture.session.apply(move(0.25));
  assert.deepEqual(fixture.stream.edits.map(({ sequence }) => sequence), [2n]);
});

test('edits that were made meanwhile are sent to the same scene, in their order', async (t) => {
  const fixture = await lost(t);
  fixture.session.apply(move(0.125));
  fixture.session.apply(move(0.0625));

  fixture.stream.hello(8n);
  fixture.accept(2n, 9n);
  fixture.accept(3n, 10n);

  assert.deepEqual(fixture.stream.edits.map(({ sequence }) => sequence), [2n, 3n]);
  assert.deepEqual(fixture.said, []);
});

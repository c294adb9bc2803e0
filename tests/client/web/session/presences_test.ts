// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a window shows of itself to others, and how often; whose camera a follower shows.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { Code } from '@connectrpc/connect';
import { PresenceSchema, type Presence as PresenceMessage } from 'latticed/v1/event_pb';
import { Feature } from 'latticed/v1/server_pb';
import { Presences } from '@src/session/presences';
import { leaderOf } from '@src/session/following';
import type { Presence } from '@src/session/scene_session';
import type { CameraPose } from '@src/state/camera_pose';
import { clipped, personOf, PERSON_COLOURS } from '@src/state/person';
import { rememberedSettings } from '@src/state/settings';
import { fromCamera } from '@src/wire/camera_message';
import { ServerError } from '@src/wire/server_error';
import { SessionFixture, until } from '../support/session_fixture';

const POSE: CameraPose = { position: [0, -5, 1], target: [0, 0, 1], up: [0, 0, 1], projection: { fovY: 40 } };

function poseAt(x: number): CameraPose {
  return { ...POSE, position: [x, -5, 1] };
}

/** Replaces the clock and timers, of which one runs at a time; returns a function that lets milliseconds pass. */
function fakeClock(t: TestContext): (ms: number) => void {
  let now = 10_000;
  let next: { at: number; then: () => void } | undefined;
  t.mock.method(performance, 'now', () => now);
  t.mock.method(globalThis, 'setTimeout', (then: () => void, ms: number) => (next = { at: now + ms, then }));
  t.mock.method(globalThis, 'clearTimeout', () => (next = undefined));
  return (ms) => {
    for (const end = now + ms; now < end; ) {
      if (++now < (next?.at ?? Infinity)) continue;
      const { then } = next!;
      next = undefined;
      then();
    }
  };
}

/** Moves the camera each 10 ms for two seconds. Returns what was sent. */
function orbit(presences: Presences, sent: readonly Presence[], pass: (ms: number) => void): Presence[] {
  const before = sent.length;
  for (let x = 1; x <= 200; ++x) {
    presences.announce({ camera: poseAt(x) });
    pass(10);
  }
  return sent.slice(before);
}

test('a moving camera is sent 10 times a second, once a second while nobody else is here, and not at rest', (t) => {
  const pass = fakeClock(t);
  const sent: Presence[] = [];
  const presences = new Presences((own) => sent.push(own));
  presences.opened();
  pass(2000);
  assert.equal(sent.length, 0, 'nothing is known of oneself yet');
  presences.announce({ name: 'Ada', colour: 1, camera: POSE });
  pass(2000);
  assert.equal(sent.length, 1);

  assert.equal(orbit(presences, sent, pass).length, 2);
  pass(1000);
  assert.deepEqual(sent.at(-1)!.camera, poseAt(200), 'the newest is sent in the end');
  pass(5000);
  presences.take(create(PresenceSchema, { editorId: 'b', name: 'Bo' }));
  const amongOthers = orbit(presences, sent, pass);

  assert.ok(amongOthers.length >= 19 && amongOthers.length <= 21, `${amongOthers.length} in two seconds`);
  assert.ok(amongOthers.every(({ name, colour }) => name === 'Ada' && colour === 1), 'each message holds everything');
  pass(200);
  const { length } = sent;
  pass(5000);
  assert.equal(sent.length, length);
});

test('a stream that opens again gets all of it at once', (t) => {
  const pass = fakeClock(t);
  const sent: Presence[] = [];
  const presences = new Presences((own) => sent.push(own));
  presences.announce({ name: 'Ada', selected: Uint32Array.of(3) });
  presences.announce({ camera: POSE });
  pass(1);
  presences.announce({ camera: poseAt(1) }); // would wait for a second

  presences.opened();
  pass(1);

  assert.deepEqual(sent.at(-1), { name: 'Ada', colour: 0, selected: Uint32Array.of(3), lattice: 0, camera: poseAt(1), following: '' });
  assert.equal(sent.length, 2);
});

async function sentBy(t: TestContext, change: Partial<Presence>): Promise<PresenceMessage> {
  const { session, stream } = await SessionFixture.live(t, { features: [Feature.PRESENCE] });
  session.announce(change);
  return new Promise((resolve) => {
    const look = (): void => {
      for (const { message } of stream.sent) if (message.case === 'presence') return resolve(message.value);
      setTimeout(look, 1);
    };
    look();
  });
}

test('a session sends name, colour, camera and whom one follows, and hears those of others', async (t) => {
  const height = { ...POSE, projection: { height: 3 } };
  const message = await sentBy(t, { name: 'Ada', colour: 7, camera: height, following: 'b', lattice: 1 });
  assert.deepEqual([message.name, message.colour, message.camera?.projection], ['Ada', 7, { case: 'height', value: 3 }]);
  assert.deepEqual([message.following, message.lattice], ['b', 1]);

  const fixture = await SessionFixture.live(t);
  const seen: (CameraPose | undefined)[] = [];
  fixture.session.on('presence', (others) => seen.push(...[...others.values()].map(({ camera }) => camera)));
  fixture.stream.event({ case: 'presence', value: { editorId: 'b', camera: fromCamera(height)! } });
  fixture.stream.event({ case: 'presence', value: { editorId: 'b', camera: fromCamera(POSE)! } });
  fixture.stream.event({ case: 'presence', value: { editorId: 'b', camera: { position: { x: 1 } } } }); // of a later version
  assert.deepEqual(seen, [height, POSE, undefined]);
  assert.deepEqual([...fixture.session.others.keys()], ['b'], 'who listens later knows them too');
  fixture.stream.event({ case: 'presence', value: { editorId: 'b', following: 'c', lattice: 1 } });
  const { following, lattice } = fixture.session.others.get('b')!;
  assert.deepEqual([following, lattice], ['c', 1]);
});

/** Others by id, with whom each follows. All show a camera, unless they are in `hidden`. */
function following(list: Readonly<Record<string, string>>, hidden = ''): Map<string, Presence> {
  const presence = ([id, followed]: [string, string]): [string, Presence] =>
    [id, { name: id, colour: 0, selected: new Uint32Array(), lattice: 0, following: followed, ...(!hidden.includes(id) && { camera: POSE }) }];
  return new Map(Object.entries(list).map(presence));
}

test('the camera that a follower shows is that at the end of the chain, as far as it is known', () => {
  assert.equal(leaderOf('a', 'b', following({ b: '' })), 'b');
  assert.equal(leaderOf('a', 'b', following({ b: 'c', c: 'd', d: '' })), 'd');
  assert.equal(leaderOf('a', 'b', following({ b: 'c', c: 'd' })), 'c', 'd has left, or is not known yet');
  assert.equal(leaderOf('a', 'b', following({ b: 'c', c: 'd', d: '' }, 'd')), 'c', 'd shows no camera');
  assert.equal(leaderOf('a', 'b', new Map()), 'b');
});

test('in a circle all find the one who stands, whether it has stopped or not', () => {
  for (const circle of ['ab', 'abc', 'acb', 'abcd', 'adbc']) {
    const next = (id: string): string => circle[(circle.indexOf(id) + 1) % circle.length]!;
    for (const hasStopped of [false, true]) {
      const all = following(Object.fromEntries([...circle].map((id) => [id, hasStopped && id === 'a' ? '' : next(id)])));
      for (const id of circle) {
        const others = new Map(all);
        others.delete(id);
        assert.equal(leaderOf(id, next(id), others), 'a', `${id} of ${circle}`);
      }
      assert.equal(leaderOf('z', next('a'), all), 'a', 'somebody outside of it follows one of it');
    }
  }
});

test('a token that may only watch is refused once; later sessions of the page show nothing', async (t) => {
  const features = [Feature.PRESENCE];
  const fixture = await SessionFixture.live(t, { features });
  const shows = ({ stream }: SessionFixture): boolean => stream.sent.some(({ message }) => message.case === 'presence');
  fixture.session.announce({ name: 'Ada' });
  await until(() => shows(fixture));
  await fixture.reconnect(new ServerError(Code.PermissionDenied, '', 'it needs the role edit'));

  const later = await SessionFixture.live(t, { features, server: fixture.server });
  later.session.announce({ name: 'Ada' });
  await new Promise((resolve) => setTimeout(resolve, 1)); // after the session's timer, which was set before
  assert.deepEqual([shows(fixture), shows(later)], [false, false]);
});

test('a name is cut to what the server takes, in code points', async (t) => {
  const message = await sentBy(t, { name: '🦊🦊🦊🦊🦊🦊🦊🦊 of the house' }); // FakeServer takes 8
  assert.equal(message.name, '🦊🦊🦊🦊🦊🦊🦊🦊');
  assert.equal(clipped('Ada', 8), 'Ada');
});

const UNSEEN: readonly (readonly [string, Partial<CameraPose>])[] = [
  ['too far away', { position: [2e15, 0, 0] }],
  ['not a number', { target: [NaN, 0, 0] }],
  ['at its target', { target: POSE.position }],
  ['with no direction up', { up: [0, 0, 0] }],
  ['infinitely high', { projection: { height: Infinity } }],
  ['with no angle', { projection: { fovY: 0 } }],
];

for (const [what, change] of UNSEEN) {
  test(`a camera ${what} is not sent, since the server would end the stream`, async (t) => {
    assert.equal((await sentBy(t, { name: 'Ada', camera: { ...POSE, ...change } })).camera, undefined);
  });
}

test('what one does not choose comes from the window, or from the colour', () => {
  const [plum, teal] = PERSON_COLOURS;
  assert.deepEqual(personOf({ name: '', colour: 'random' }, plum), plum);
  assert.deepEqual(personOf({ name: '', colour: teal.colour }, plum), teal);
  assert.deepEqual(personOf({ name: 'Ada', colour: 'random' }, plum), { name: 'Ada', colour: plum.colour });
});

test('name and colour are remembered', () => {
  const kept = new Map<string, string>();
  const storage = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => void kept.set(key, value) };
  rememberedSettings(storage).set({ you: { name: 'Ada', colour: 0x2ec4b6 } });

  assert.deepEqual(rememberedSettings(storage).value.you, { name: 'Ada', colour: 0x2ec4b6 });
});

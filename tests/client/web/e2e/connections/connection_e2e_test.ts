// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium when the network between it and the server fails and the server runs on.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { followsDefinition } from '../support/definition';
import { openPage } from '../support/browser';
import { withData } from '../support/restarts';
import { tapSockets, type TappedSocket } from './socket_tap';
import { browser, CORNER, moveCorner, page, pointAtServer, revision, server, setView, until, useStage } from '../support/stage';
import { TcpProxy } from '../support/tcp_proxy';
import { torusObj } from '../support/torus';
import { controlPoint, createScene, dropFiles, live, segmentsCome } from '../support/viewer_page';

const OBJ = torusObj(24, 12); // the corner changes only one of eight knot boxes, so most chunks stay

let proxy: TcpProxy;
let sockets: TappedSocket[];
let scene: string;

const data = withData();
const heartbeat = (interval: string): string[] => [...data, '--heartbeat-interval', interval]; // a page notices a silence of three

useStage({
  serverOptions: heartbeat('60s'), // longer than any test, also on a slow machine
  address: async () => (proxy = await TcpProxy.to(server.port)).origin,
  begin: async () => {
    sockets = tapSockets(page);
    await dropFiles(page, [['torus.obj', OBJ]]);
    await createScene(page);
    scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
    // Reading a surface back must not keep the page from heartbeats. On a slow machine the page would choose Meshopt
    // by itself, perhaps between two streams, and a stream in another encoding cannot be resumed.
    await setView({ segments: 1, encoding: 'draco' });
    await segmentsCome(page, 1);
  },
});
after(() => proxy.close());

/** Records the session's states from now on. The returned function gives them. */
async function states(): Promise<() => Promise<string[]>> {
  const told = await page.evaluateHandle(() => {
    const all: string[] = [];
    window.latticed.scene!.session.on('status', ({ state }) => all.push(state));
    return all;
  });
  return () => told.jsonValue();
}

/** Waits until the page and the server have the corner at `target`, and the surface follows the definition. */
async function arrives(target: readonly number[]): Promise<void> {
  await until(async () => String(await pointAtServer(CORNER)) === String(target));
  assert.deepEqual(await controlPoint(page, CORNER), target);
  await followsDefinition(page, OBJ);
}

/** Checks that all sockets after the first `since` resumed the stream, and brought only some of the chunks. */
function assertResumed(since: number): void {
  const later = sockets.slice(since).filter(({ hello }) => hello !== undefined);
  const chunks = later.reduce((sum, socket) => sum + socket.chunks, 0);
  const all = sockets[0].chunksOfTopology;
  assert.ok(later.length > 0 && later.every(({ hello }) => hello!.resumed), `${later.map(({ hello }) => hello!.resumed)}`);
  assert.ok(chunks > 0 && chunks < all / 2, `${chunks} of ${all} chunks`);
}

test('a connection that is cut in the middle of edits comes back by itself: each counts once, what has not changed stays', async () => {
  const [first, [x, y, z]] = [await revision(), await controlPoint(page, CORNER)];
  const told = await states();
  const opened = sockets.length;

  proxy.holdAnswers();
  await moveCorner([-0.25, 0, 0]); // arrives, but its answer does not
  await until(async () => (await revision()) === first + 1);
  await moveCorner([0, -0.25, 0]); // waits for that answer
  proxy.cut();
  await page.locator('.connection[data-state=retrying]').waitFor();
  await page.locator('.banner').getByText('The server cannot be reached. Trying again …').waitFor();
  await moveCorner([0, 0, -0.25]); // only the page has this edit
  assert.equal(await revision(), first + 1);
  proxy.mend();
  await page.locator('.connection[data-state=live]').waitFor();
  await page.locator('.banner').waitFor({ state: 'hidden' });

  await arrives([x - 0.25, y - 0.25, z - 0.25]);
  assert.equal(await revision(), first + 3);
  assertResumed(opened);
  assert.deepEqual([...new Set(await told())], ['retrying', 'live']);
});

test('when the browser says that its network is back, the page opens another connection', async () => {
  const [first, [x, y, z]] = [await revision(), await controlPoint(page, CORNER)];
  const opened = sockets.length;

  proxy.freeze(); // Chromium lets an open WebSocket go on while its page is offline
  await page.context().setOffline(true);
  await moveCorner([0, 0.125, 0]);
  await page.context().setOffline(false);
  await until(() => sockets.slice(opened).some(({ hello }) => hello !== undefined));

  await arrives([x, y + 0.125, z]);
  assert.equal(await revision(), first + 1);
  assertResumed(opened);
});

test('a page that is looked at after a sleep, in which nothing came, opens another connection at once', async () => {
  const opened = sockets.length;

  const state = await page.evaluate(() => {
    const { now } = Date;
    Date.now = () => now() + 3_600_000; // an hour later, in which timers stood still
    document.dispatchEvent(new Event('visibilitychange'));
    Date.now = now;
    return window.latticed.scene!.session.status.state;
  });

  assert.equal(state, 'retrying');
  await until(() => sockets.slice(opened).some(({ hello }) => hello?.resumed === true));
});

test('a connection that neither carries anything nor ends is noticed, and another takes its place', async () => {
  await server.kill();
  await page.locator('.connection[data-state=retrying]').waitFor();
  await server.restart(heartbeat('600ms'));
  await live(page);
  const [first, [x, y, z]] = [await revision(), await controlPoint(page, CORNER)];
  const told = await states();
  const opened = sockets.length;

  proxy.shut(); // until the server has been asked: on a slow machine the page may notice before that
  proxy.freeze();
  const cut = Date.now();
  await moveCorner([0.125, 0, 0]);
  assert.equal(await revision(), first);
  proxy.mend();
  await until(async () => (await told()).at(-1) === 'live');
  const pause = Date.now() - cut;
  console.log(`the page went on after ${pause} ms`); // 1.8 s is expected
  assert.ok(pause < 30_000, `${pause} ms`);

  await arrives([x + 0.125, y, z]);
  assert.equal(await revision(), first + 1);
  assertResumed(opened);
});

test('a slow line that is busy with a large update is not taken for one that is cut', async () => {
  const line = await TcpProxy.to(server.port, 200_000);
  after(() => line.close());
  const { page: distant } = await openPage(browser, line.origin);
  const opened = tapSockets(distant);
  await distant.goto(`${line.origin}/?scene=${scene}`);
  await live(distant);

  await setView({ segments: 16, encoding: 'raw' }, distant); // two megabytes
  await segmentsCome(distant, 16);

  assert.equal(opened.length, 1);
  await distant.close();
});

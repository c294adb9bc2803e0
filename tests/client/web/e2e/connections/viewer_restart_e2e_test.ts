// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium when its server, which keeps its data in a folder, is killed and started again: the page goes on
// by itself, and what was edited meanwhile arrives.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Vec3 } from '@src/lattice/vec';
import { followsDefinition } from '../support/definition';
import { keepToasts, withData } from '../support/restarts';
import { CORNER, errors, moveCorner, OBJ, openTorus, page, pointAtServer, press, revision, server, until, useStage } from '../support/stage';
import { controlPoint, live, pointComesTo } from '../support/viewer_page';

const DOWN_MS = 500;
const MOST_PAUSE_MS = 10_000; // after the new server listens; below a second without a stall of the machine

useStage({ serverOptions: withData(), begin: () => openTorus(1) });

/** Waits until the page and the server have the corner at a place. */
async function arrives(target: Vec3): Promise<void> {
  await until(async () => String(await pointAtServer(CORNER)) === String(target));
  await pointComesTo(page, CORNER, target);
  assert.deepEqual(await controlPoint(page, CORNER), target);
}

test('a page goes on after its server was killed: edits made meanwhile arrive once, and older ones can be undone', async () => {
  const [first, [x, y, z]] = [await revision(), await controlPoint(page, CORNER)];
  await keepToasts(page);
  await moveCorner([0.25, 0, 0]);
  await until(async () => (await revision()) === first + 1);
  const told = await page.evaluateHandle(() => {
    const all: { readonly state: string; readonly at: number }[] = [];
    window.latticed.scene!.session.on('status', ({ state }) => all.push({ state, at: Date.now() }));
    return all;
  });

  await server.kill();
  await page.locator('.connection[data-state=retrying]').waitFor();
  await moveCorner([0, 0.25, 0]);
  await moveCorner([0, 0, 0.25]);
  await new Promise((resolve) => setTimeout(resolve, DOWN_MS));
  await server.restart();
  const restarted = Date.now();
  await live(page);

  await arrives([x + 0.25, y + 0.25, z + 0.25]);
  assert.equal(await revision(), first + 3);
  const states = await told.jsonValue();
  assert.deepEqual([...new Set(states.map(({ state }) => state))], ['retrying', 'live']);
  const pause = states.find(({ state }) => state === 'live')!.at - restarted;
  console.log(`the page went on ${pause} ms after the restart`);
  assert.ok(pause < MOST_PAUSE_MS, `${pause} ms`);
  await followsDefinition(page, OBJ);

  await press('Control+z', 'Control+z', 'Control+z'); // the third is from before the kill
  await arrives([x, y, z]);
  assert.equal(await revision(), first + 6);
  assert.deepEqual(await page.evaluate(() => (window as unknown as { toasts: string[] }).toasts), []);
  const ofKill = /ERR_(CONNECTION_|INCOMPLETE_CHUNKED_ENCODING)/; // a call while the server was down, or one that its end cut
  assert.deepEqual(errors.filter((text) => !ofKill.test(text)), []);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Many windows of one browser on one scene: a browser opens six HTTP/1.1 connections to a server for all of them together.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import type { BrowserContext, Page } from 'playwright-core';
import { randomId } from '@src/wire/ids';
import { uploadMesh } from '@src/wire/upload';
import { stopWebSockets } from './browser';
import { followsDefinition } from './definition';
import { browser, direct, OBJ, server, until, useStage } from './stage';
import { live } from './viewer_page';

let scene: string;

async function openWindow(context: BrowserContext): Promise<Page> {
  const page = await context.newPage();
  await page.goto(`${server.origin}/?scene=${scene}`, { waitUntil: 'commit' });
  return page;
}

/** Moves a control point down, 1/16 at a time: sums of that are exact. */
function move(page: Page, index: number, steps: number): Promise<void> {
  return page.evaluate(
    ([i, times]) => {
      for (let step = 0; step < times; ++step)
        window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(i), offset: [0, 0, -1 / 16] });
    },
    [index, steps] as const,
  );
}

/** What the server has. */
async function controlPoints(): Promise<number[]> {
  return (await direct.scenes.getLattice({ scene })).lattice!.controlPoints;
}

/** Waits until the server and a window have these control points. */
async function haveAll(page: Page, expected: readonly number[]): Promise<void> {
  await until(async () => String(await controlPoints()) === String(expected));
  await page.waitForFunction((all) => String(window.latticed.scene!.session.lattice.points) === all, String(expected));
}

/** `points` with some moved down. */
function moved(points: readonly number[], steps: ReadonlyMap<number, number>): number[] {
  return points.map((value, i) => value - (i % 3 === 2 ? (steps.get((i - 2) / 3) ?? 0) / 16 : 0));
}

useStage({
  begin: async () => {
    const mesh = await uploadMesh(direct, { format: MeshFormat.OBJ }, new Blob([OBJ]));
    // Few points: the windows share a processor, which also draws.
    scene = (await direct.scenes.createScene({ mesh: mesh.id, sceneId: randomId(), defaultView: { segments: 2 } })).id;
  },
});

test('twelve windows of one browser edit and pick at once: all have one lattice, and the surface that the definition says', async () => {
  const context = await browser.newContext({ viewport: { width: 320, height: 240 } });
  const windows = await Promise.all(Array.from({ length: 12 }, () => openWindow(context)));
  await Promise.all(windows.map((page) => live(page)));
  const before = await controlPoints();

  const hits = await Promise.all(windows.map(async (page, i) => {
    await move(page, 5 * i, 3);
    const angle = (2 * Math.PI * i) / 12; // down onto the middle of the tube
    return page.evaluate(async ([x, y]) => {
      const hit = await window.latticed.scene!.session.pick([x, y, 10], [0, 0, -1]);
      return Math.hypot(hit!.position[0] - x, hit!.position[1] - y);
    }, [Math.cos(angle), Math.sin(angle)] as const);
  }));

  hits.forEach((off) => assert.ok(off < 1e-9, `${hits}`));
  const expected = moved(before, new Map(windows.map((_, i) => [5 * i, 3])));
  for (const page of windows) {
    await haveAll(page, expected);
    await followsDefinition(page, OBJ);
  }
  await context.close();
});

test('where no WebSocket passes five windows edit and pick; a sixth says what to do, and goes on when one is closed', async () => {
  const context = await browser.newContext({ viewport: { width: 320, height: 240 } });
  await stopWebSockets(context);
  const windows = await Promise.all(Array.from({ length: 5 }, () => openWindow(context)));
  await Promise.all(windows.map((page) => live(page)));
  const before = await controlPoints();

  const sixth = await openWindow(context);
  await sixth.locator('.banner').getByText('without WebSockets a browser shows 5 of its windows at once: close one of them').waitFor();
  const hits = await Promise.all(windows.map(async (page, i) => {
    await move(page, 7 * i, 2);
    return page.evaluate(async () => (await window.latticed.scene!.session.pick([1, 0, 10], [0, 0, -1])) !== undefined);
  }));
  assert.deepEqual(hits, [true, true, true, true, true]);
  const expected = moved(before, new Map(windows.map((_, i) => [7 * i, 2])));
  for (const page of windows) await haveAll(page, expected);

  await windows[0].close();
  await live(sixth);
  await sixth.locator('.banner').waitFor({ state: 'hidden' });
  await move(sixth, 63, 1);
  const final = moved(expected, new Map([[63, 1]]));
  for (const page of [sixth, ...windows.slice(1)]) {
    await haveAll(page, final);
    await followsDefinition(page, OBJ);
  }
  await context.close();
});

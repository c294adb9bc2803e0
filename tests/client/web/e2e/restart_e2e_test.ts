// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Two windows on one scene when the server, which keeps nothing, is killed and started again: one of them is quicker and
// restores the scene, the other goes on with it. Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { BrowserContext, Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { allHave, keeps, keepToasts, shownBy, stageOfFile, whoRestored } from './restarts';
import { torusObj } from './torus';
import { createScene, dropFiles, live } from './viewer_page';

const OBJ = torusObj(12, 8);

const stage = stageOfFile();

async function openWindow(context: BrowserContext, path: string): Promise<Page> {
  const page = await context.newPage();
  await page.goto(stage.server.origin + path);
  return page;
}

/** Moves a control point down by quarters, whose sums are exact. */
function move(page: Page, index: number, quarters: number): Promise<void> {
  return page.evaluate(
    ([i, n]) => window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(i), offset: [0, 0, -n / 4] }),
    [index, quarters] as const,
  );
}

/** `points` with one moved down. */
function moved(points: readonly number[], index: number, quarters: number): number[] {
  return points.map((value, i) => (i === 3 * index + 2 ? value - quarters / 4 : value));
}

for (const [whose, isOther] of [['one browser', false], ['two browsers', true]] as const) {
  test(`two windows of ${whose}: a scene is restored once, both say so, and edits of either one are right in the other`, async (t) => {
    const view = { viewport: { width: 480, height: 360 } };
    const context = await stage.browser.newContext(view);
    const otherContext = isOther ? await stage.browser.newContext(view) : context;
    t.after(async () => {
      await context.close();
      if (isOther) await otherContext.close();
    });
    const first = await openWindow(context, '/');
    await dropFiles(first, [['torus.obj', OBJ]]);
    await createScene(first);
    const { pathname, search } = new URL(first.url());
    const second = await openWindow(otherContext, pathname + search);
    const windows = [first, second];
    const scene = await first.evaluate(() => window.latticed.scene!.session.sceneId);
    for (const page of windows) {
      await live(page);
      await page.evaluate(() => window.latticed.scene!.session.setView({ segments: 2 })); // few points: one processor draws all
      await keeps(page);
      await keepToasts(page);
    }
    await move(first, 0, 1);
    let expected = await shownBy(first);
    await allHave(stage.direct, scene, windows, expected, OBJ);

    await stage.server.kill();
    for (const page of windows) await page.locator('.connection[data-state=retrying]').waitFor();
    await move(first, 21, 1); // people go on meanwhile
    await move(second, 63, 2);
    await stage.server.restart();

    const said = await Promise.all(windows.map(whoRestored));
    assert.deepEqual(said.sort(), ['another window', 'this browser']);
    expected = moved(moved(expected, 21, 1), 63, 2);
    await allHave(stage.direct, scene, windows, expected, OBJ);
    assert.deepEqual((await stage.direct.scenes.listScenes({})).scenes.map(({ id }) => id), [scene]);
    await move(first, 5, 3);
    await move(second, 42, 1);
    expected = moved(moved(expected, 5, 3), 42, 1);
    await allHave(stage.direct, scene, windows, expected, OBJ);
    await second.evaluate(() => window.latticed.scene!.session.undo());
    expected = moved(expected, 42, -1);
    await allHave(stage.direct, scene, windows, expected, OBJ);
  });
}

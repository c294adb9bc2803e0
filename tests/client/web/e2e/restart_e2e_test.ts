// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Two windows on one scene when the server, which keeps nothing, is killed and started again: one of them is quicker and
// restores the scene, the other goes on with it. Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { BrowserContext, Page } from 'playwright-core';
import { allHave, keeps, keepToasts, toldOf, whoRestored } from './restarts';
import { allPoints, browser, CORNER, direct, OBJ, openTorus, page, press, select, server, until, useStage } from './stage';
import { controlPoint, createScene, dropFiles, frames, live, onScreen } from './viewer_page';

const LET_GO = 'The server was restarted, so what was being moved was let go where it was.';

useStage({ context: { viewport: { width: 640, height: 480 } } });

async function openWindow(context: BrowserContext, path: string): Promise<Page> {
  const page = await context.newPage();
  await page.goto(server.origin + path);
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
function lowered(points: readonly number[], index: number, quarters: number): number[] {
  return points.map((value, i) => (i === 3 * index + 2 ? value - quarters / 4 : value));
}

for (const [whose, isOther] of [['one browser', false], ['two browsers', true]] as const) {
  test(`two windows of ${whose}: a scene is restored once, both say so, and edits of either one are right in the other`, async (t) => {
    const view = { viewport: { width: 480, height: 360 } };
    const context = await browser.newContext(view);
    const otherContext = isOther ? await browser.newContext(view) : context;
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
    let expected = await allPoints(first);
    await allHave(scene, windows, expected, OBJ);

    await server.kill();
    for (const page of windows) await page.locator('.connection[data-state=retrying]').waitFor();
    await move(first, 21, 1); // people go on meanwhile
    await move(second, 63, 2);
    await server.restart();

    const said = await Promise.all(windows.map(whoRestored));
    assert.deepEqual(said.sort(), ['another window', 'this browser']);
    expected = lowered(lowered(expected, 21, 1), 63, 2);
    await allHave(scene, windows, expected, OBJ);
    assert.deepEqual((await direct.scenes.listScenes({})).scenes.map(({ id }) => id), [scene]);
    await move(first, 5, 3);
    await move(second, 42, 1);
    expected = lowered(lowered(expected, 5, 3), 42, 1);
    await allHave(scene, windows, expected, OBJ);
    await second.evaluate(() => window.latticed.scene!.session.undo());
    expected = lowered(expected, 42, -1);
    await allHave(scene, windows, expected, OBJ);
  });
}

test('a move by G whose server is killed goes on in the cage, and is let go once where it was when the server is back', async () => {
  await openTorus();
  const scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  await page.evaluate(() => window.latticed.settings.set({ gizmo: 'none' }));
  await keeps(page);
  await keepToasts(page);
  await frames(page);
  const rest = await allPoints();
  const [x, y] = await onScreen(page, CORNER);
  await select(CORNER);
  await page.mouse.move(x, y);
  await press('g');
  await page.mouse.move(x - 20, y + 10, { steps: 4 });
  await until(async () => (await direct.scenes.getLattice({ scene })).lattice!.controlPoints[3 * CORNER] !== rest[3 * CORNER]);
  await page.mouse.move(x - 40, y + 20, { steps: 4 }); // some of these are on their way
  await server.kill();
  await page.locator('.connection[data-state=retrying]').waitFor();
  const cut = await controlPoint(page, CORNER);
  await page.mouse.move(x - 60, y + 30, { steps: 4 });
  const there = await controlPoint(page, CORNER);
  assert.notDeepEqual(there, cut); // the cage answers without a server
  const moved = rest.map((value, i) => (i >= 3 * CORNER ? there[i - 3 * CORNER] : value));

  await server.restart();
  assert.equal(await whoRestored(page), 'this browser');
  await toldOf(page, LET_GO);
  await page.locator('.connection[data-state=restored]').waitFor();
  assert.equal(await page.locator('.hint.running').count(), 0);
  await page.mouse.move(x - 100, y + 80, { steps: 4 });
  await press('Enter');
  await page.mouse.click(20, 460);
  await allHave(scene, [page], moved, OBJ);
  await press('Control+z');
  await toldOf(page, '^There is nothing to undo\\.');
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium where it evaluates patches by itself: what it shows against the server's own points, without a network,
// as the camera moves, and where the GPU cannot do it.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { distance } from '@src/lattice/vec';
import { evaluated, followsServer } from './against_server';
import { openPage } from '../support/browser';
import { deformed, followsDefinition, shownBy } from '../support/definition';
import { sourcePlaces } from '../support/source_places';
import { browser, CORNER, errors, OBJ, page, pointAtServer, press, setView, shot, server, until, useStage } from '../support/stage';
import { TcpProxy } from '../support/tcp_proxy';
import { controlPoint, createScene, dropFiles, frames, live } from '../support/viewer_page';

let proxy: TcpProxy;
const calls: string[] = []; // the page's calls to the server

useStage({
  address: async () => (proxy = await TcpProxy.to(server.port)).origin,
  begin: async () => {
    page.on('request', (request) => calls.push(request.url().split('/').at(-1)!));
    await dropFiles(page, [['torus.obj', OBJ]]);
    await createScene(page);
    await evaluated(page);
  },
});
after(() => proxy.close());

function move(index: number, offset: readonly [number, number, number]): Promise<void> {
  return page.evaluate(([i, by]) =>
    window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(i), offset: by as never }), [index, offset] as const);
}

const pointCount = (of = page): Promise<number> => of.evaluate(() => window.latticed.scene!.session.surface.pointCount);
const hud = (name: string): Promise<string | null> => page.locator(`[data-hud=${name}]`).textContent();

test('a page evaluates by itself what it shows: every point is where the server says, and so is its normal', async () => {
  await setView({ normals: 'facet' });
  await until(async () => page.evaluate(() => window.latticed.scene!.session.surface.edgeBounds.normals === 2));
  await move(CORNER, [0.5, 0.25, 0.75]);
  await followsDefinition(page, OBJ);

  await followsServer(page, OBJ);
  assert.deepEqual(errors, []);
});

/** How many edits the line of figures has measured from the edit to its pixels. */
const measured = (): Promise<number> =>
  page.evaluate(() => (window.latticed as unknown as { hud: { latencies: number[] } }).hud.latencies.length);

test('an update is small, and the line of figures tells points and the error that holds; an edit is measured once', async () => {
  const [before, edits] = [calls.length, await measured()];
  await move(CORNER, [0.01, 0, 0]);
  await until(async () => String(await pointAtServer(CORNER)) === String(await controlPoint(page, CORNER)));
  await evaluated(page);

  assert.match((await hud('bytes'))!, /^\d{1,3} bytes$/);
  await until(async () => (await hud('points')) === (await pointCount()).toLocaleString('en')); // soon finer, as at rest
  assert.match((await hud('error'))!, /^0\.00\d+ units$/);
  assert.ok(!calls.slice(before).includes('GetPatchPlan'), 'the plan was fetched once');
  await until(async () => (await measured()) > edits);
  assert.equal(await measured(), edits + 1);
});

test('a frame for which nothing is evaluated leaves the state of the GPU to the renderer', async () => {
  await page.evaluate(() => {
    const { renderer } = window.latticed.viewport;
    const resetState = renderer.resetState.bind(renderer);
    Object.assign(window, { resets: 0 });
    renderer.resetState = () => {
      ++(window as unknown as { resets: number }).resets;
      resetState();
    };
  });
  const resets = (): Promise<number> => page.evaluate(() => (window as unknown as { resets: number }).resets);
  await until(async () => { // levels are chosen once more after the edit before
    const before = await resets();
    for (let frame = 0; frame < 3; ++frame) {
      await page.evaluate(() => window.latticed.viewport.invalidate());
      await frames(page);
    }
    return (await resets()) === before;
  });
  const before = await resets();
  await move(CORNER, [0, 0.01, 0]);
  await until(async () => (await resets()) > before);
  await evaluated(page);
});

test('the camera changes the levels of edges and asks the server for nothing', async () => {
  const zoom = async (by: number): Promise<void> => {
    for (let turn = 0; turn < 8; ++turn) await page.mouse.wheel(0, by);
  };
  const [x, y] = await page.evaluate(() => {
    const box = window.latticed.viewport.canvas.getBoundingClientRect();
    return [box.left + box.width / 2, box.top + box.height / 2];
  });
  await page.mouse.move(x, y);
  const before = await pointCount();
  const asked = await page.evaluate(() => JSON.stringify(window.latticed.scene!.session.askedView));
  await until(async () => { // the volume is measured a quarter of a second after the edit before
    const called = calls.length;
    await page.evaluate(() => new Promise((resolve) => setTimeout(resolve, 1000))); // by the page's clock: it may stand still
    return calls.length === called;
  });
  const called = calls.length;

  await zoom(-200);
  await until(async () => (await pointCount()) > 1.1 * before);
  await zoom(400);
  await until(async () => (await pointCount()) < before);
  await zoom(-200);
  await until(async () => Math.abs((await pointCount()) / before - 1) < 0.3);

  assert.deepEqual(calls.slice(called), []);
  assert.equal(await page.evaluate(() => JSON.stringify(window.latticed.scene!.session.askedView)), asked);
  await followsDefinition(page, OBJ);
});

test('an edit shows while the network is cut, and stays once it is back', async () => {
  const target = (await controlPoint(page, CORNER)).map((x, axis) => (axis === 2 ? x - 0.5 : x));
  const atServer = await pointAtServer(CORNER);
  const { topology, spots } = await shownBy(page);
  const { places } = (await until(() => sourcePlaces(page, topology, spots, OBJ)))!;
  const rest = new Map(spots.map(({ patch, weights }, n) => [`${patch} ${weights}`, places[n]]));
  /** The largest distance of the corners of patches from where the page's lattice puts them. */
  const worst = async (): Promise<number> => {
    const { lattice, ...shown } = await shownBy(page);
    const corners = shown.spots.flatMap(({ patch, weights }, n) => (weights.includes(1) ? [{ n, place: rest.get(`${patch} ${weights}`)! }] : []));
    return Math.max(...corners.map(({ n, place }) => distance(shown.points[n], deformed(lattice, place))));
  };
  proxy.cut();
  await page.locator('.connection[data-state=retrying]').waitFor();

  await move(CORNER, [0, 0, -0.5]);
  await until(async () => (await worst()) < 4e-5);
  assert.deepEqual(await pointAtServer(CORNER), atServer);
  assert.equal(await hud('error'), '–'); // no bound is known before the server has answered
  proxy.mend();

  await page.locator('.connection[data-state=live]').waitFor();
  await until(async () => String(await pointAtServer(CORNER)) === String(target));
  await evaluated(page);
  await followsDefinition(page, OBJ);
  errors.length = 0; // the console reports the cut
});

test('another structure of the lattice has another plan', async () => {
  await page.evaluate(() => window.latticed.scene!.session.insertKnot(0, 0.3));
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 80);
  await until(async () => calls.filter((call) => call === 'GetPatchPlan').length >= 3); // two kinds of normals, and this
  await evaluated(page);
  await followsDefinition(page, OBJ);
  await press('Control+z');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 64);
  await evaluated(page);
  await followsDefinition(page, OBJ);
});

test('the same segments everywhere come as points, and a tolerance brings the evaluation back', async () => {
  await setView({ segments: 3 });
  await page.waitForFunction(() => window.latticed.scene!.session.surface.layout?.segments === 3);
  await followsDefinition(page, OBJ);
  assert.equal(await page.evaluate(() => window.latticed.scene!.isEvaluated), false);

  await page.evaluate(() => window.latticed.settings.set({ detail: 'tolerance' }));
  await evaluated(page);
  await followsDefinition(page, OBJ);
  await shot('viewer_patches');
  assert.deepEqual(errors, []);
});

test('where the GPU cannot evaluate patches, points come within a tolerance', async () => {
  const context = await browser.newContext();
  await context.addInitScript(() => {
    const { getParameter } = WebGL2RenderingContext.prototype;
    WebGL2RenderingContext.prototype.getParameter = function (name) {
      return name === 0x8b4c ? 2 : (getParameter.call(this, name) as unknown); // MAX_VERTEX_TEXTURE_IMAGE_UNITS
    };
  });
  const { page: other, errors: wrong } = await openPage(context as never, page.url());
  await live(other);
  await other.waitForFunction(() => window.latticed.scene!.session.askedView.tolerance! > 0);

  assert.equal(await other.evaluate(() => window.latticed.scene!.session.askedView.encoding), 'auto');
  await followsDefinition(other, OBJ);
  assert.deepEqual(wrong, []);
  await context.close();
});

test('where the lattice goes on outside its frame, points are where the server says, too', async () => {
  await until(async () => page.evaluate(() => window.latticed.scene !== undefined));
  const before = await page.evaluate(() => {
    const { session } = window.latticed.scene!;
    const { lattice } = session;
    const { origin, u } = lattice.frame; // along x
    const points = lattice.points.map((x, i) => (i % 3 === 0 ? origin[0] + 0.6 * (x - origin[0]) : x));
    const part = Object.assign(Object.create(Object.getPrototypeOf(lattice) as object), lattice, {
      frame: { ...lattice.frame, u: [0.6 * u[0], 0, 0] }, points,
      outside: { mode: 'falloff', smooth: true, widths: [0, 0.4, 0, 0, 0, 0], steps: [] },
    }) as typeof lattice;
    session.replaceLattice(part, false);
    return session.surface.patchCount;
  });
  await page.waitForFunction((count) => {
    const { session } = window.latticed.scene!;
    return session.lattice.outside?.mode === 'falloff' && session.surface.patchCount !== count;
  }, before);
  await evaluated(page);
  await move(CORNER, [0.1, 0.2, 0.3]);
  await until(async () => String(await pointAtServer(CORNER)) === String(await controlPoint(page, CORNER)));

  await followsServer(page, OBJ, false);
  assert.deepEqual(errors, []);
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A session in Chromium against the real server.
// Environment: LATTICED, CHROMIUM; LATTICED_PAGE, the folder of the page; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test, type TestContext } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { launch, launchWithProfile, limitStorage, openPage, stopWebSockets } from './browser';
import { assertFlat } from './page_memory';
import { ServerProcess } from './server_process';
import { torusObj } from './torus';
import type {} from './page/harness';  // window.harness

const OBJ = torusObj(12, 8);
const FACES = 192;
const SIZE = 4;

let server: ServerProcess;
let browser: Browser;
let page: Page;
let errors: string[];
let sceneId: string;

async function shot(name: string): Promise<void> {
  if (!process.env.LATTICED_SHOTS) return;
  await page.evaluate(() => window.harness.draw());
  await page.locator('canvas').screenshot({ path: join(process.env.LATTICED_SHOTS, `${name}.png`) });
}

/** Largest distance of received points from EvaluatePoints, in grid steps. */
function worst(of = page): Promise<number> {
  return of.evaluate(async () => {
    const { harness } = window;
    await harness.settled();
    return harness.worstPoint(harness.surface.drawnLayout!.id, 1);
  });
}

/** A page of a browser of its own, which has 10 MB to keep meshes in. */
async function storingPage(t: TestContext): Promise<Page> {
  const storing = await (await launchWithProfile(t)).newPage();
  await storing.goto(server.origin);
  await limitStorage(storing, 10e6);
  return storing;
}

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_PAGE!);
  browser = await launch();
  ({ page, errors } = await openPage(browser, server.origin));
  sceneId = await page.evaluate(([obj, size]) => window.harness.makeScene(obj as string, size as number), [OBJ, SIZE]);
  await page.evaluate((id) => window.harness.open(id), sceneId);
});

after(async () => {
  await browser?.close();
  await server?.kill();
});

test('the surface appears', async () => {
  const { covered } = await page.evaluate(() => window.harness.pixels());

  assert.ok(covered > 0.1, `${covered} of the canvas`);
  assert.equal(await page.evaluate(() => window.harness.session.status.state), 'live');
  assert.deepEqual(errors, []);
  await shot('rest');
});

test('an edit moves the surface to where EvaluatePoints says, in every encoding', async () => {
  await page.evaluate(() => window.harness.session.apply({ kind: 'move', indices: Uint32Array.of(21, 22, 41, 42), offset: [0.3, 0.9, 0.4] }));
  // Half a step an axis for rounding, and what float32 evaluation adds.
  assert.ok(await worst() < 0.9);
  await shot('deformed');
  const shown: { covered: number; mean: number[] }[] = [];
  for (const encoding of ['quantised', 'raw', 'draco'] as const) {
    await page.evaluate((name) => {
      window.harness.updates.length = 0;
      window.harness.session.setView({ encoding: name, segments: 6 });
    }, encoding);
    await page.evaluate(() => window.harness.until(() => window.harness.updates.length > 0));
    const off = await worst();
    assert.ok(off < (encoding === 'raw' ? 2 : 0.9), `${encoding}: ${off}`);
    shown.push(await page.evaluate(() => window.harness.pixels()));
  }
  // Light on float normals and on decoded ones is the same, to a level of 255.
  for (const { covered, mean } of shown) {
    assert.ok(Math.abs(covered - shown[0].covered) < 0.001);
    mean.forEach((level, i) => assert.ok(Math.abs(level - shown[0].mean[i]) < 1, `${mean}, not ${shown[0].mean}`));
  }
  assert.deepEqual(errors, []);
});

test('a texture lies on the faces whose corners say so', async () => {
  const colour = async (red: number): Promise<number[]> => {
    await page.evaluate(([faces, middle]) => window.harness.paint(faces, middle), [FACES, red] as const);
    await page.waitForFunction(() => window.harness.surface.isTextured);
    return (await page.evaluate(() => window.harness.pixels())).mean;
  };
  const [red, , blue] = await colour(FACES);
  const [, green] = await colour(0);
  const [halfRed, halfGreen] = await colour(FACES / 2);
  await shot('texture');

  assert.ok(red > 2 * blue, `${red} ${blue}`);
  assert.ok(green > 2 * blue, `${green} ${blue}`);
  assert.ok(halfRed < red && halfGreen < green && halfRed > 1.3 * blue && halfGreen > 1.3 * blue, `${halfRed} ${halfGreen}`);
  await page.evaluate(() => window.harness.surface.setLook({ colouring: 'plain' }));
});

/** Geometries of the renderer, and buffers and geometries that the surface has made. */
const geometries = (): Promise<number[]> =>
  page.evaluate(() => [window.harness.geometries, window.harness.surface.geometriesMade]);

/** Steps of a drag, each of which waits for the server's update of the one before. */
const drag = (steps: number): Promise<void> => page.evaluate((n) => window.harness.drag(22, n, 0.2), steps);

test('1,000 steps of a drag make no geometry and leave what the page takes as it is', async () => {
  await drag(50);
  const count = await geometries();

  await assertFlat(page, () => drag(Number(process.env.LATTICED_DRAG_STEPS ?? 1000)));

  assert.deepEqual(await geometries(), count);
  assert.ok(await worst() < 0.9);
});

test('10,000 updates of the server make no geometry and leave what the page takes as it is', async () => {
  const show = (segments: number): Promise<void> => page.evaluate((n) => window.harness.setSegments(n), segments);
  const received = (): Promise<number> => page.evaluate(() => window.harness.received);
  await show(1);  // what stays of every update does not go with its points, as the thousand steps before show
  await drag(50);
  const [count, before] = [await geometries(), await received()];

  await assertFlat(page, () => drag(10_000));

  assert.ok(await received() >= before + 10_000, `${await received() - before} updates`);
  assert.deepEqual(await geometries(), count);
  await show(6);
  assert.ok(await worst() < 0.9);
});

test('what one window does the other shows, undo takes it back, and a refusal is said', async () => {
  const other = await openPage(browser, server.origin);
  await other.page.evaluate((id) => window.harness.open(id), sceneId);
  const z = (): Promise<number> => page.evaluate(() => window.harness.session.lattice.points[5]);
  const before = await z();

  await other.page.evaluate(() => window.harness.session.apply({ kind: 'move', indices: Uint32Array.of(1), offset: [0, 0, 2] }));
  await page.waitForFunction((was) => window.harness.session.lattice.points[5] === was + 2, before);
  await other.page.evaluate(() => window.harness.session.undo());
  await page.waitForFunction((was) => window.harness.session.lattice.points[5] === was, before);
  await other.page.evaluate(() => window.harness.session.apply({ kind: 'move', indices: Uint32Array.of(9999), offset: [0, 0, 2] }));
  await other.page.waitForFunction(() => window.harness.refused.length === 1);

  assert.match(await other.page.evaluate(() => window.harness.refused[0]), /9999/);
  assert.deepEqual(other.errors, []);
  await other.page.close();
});

test('a surface point is picked on a ray and dragged to its target', async () => {
  const off = await page.evaluate(async () => {
    const { harness } = window;
    const [x, y, z] = harness.surface.positionOf(100);
    const point = (await harness.session.pick([x, y, z + 10], [0, 0, -1]))!;
    const targets = Float64Array.of(point.position[0] + 0.1, point.position[1], point.position[2] + 0.2);
    harness.session.apply({ kind: 'drag', points: [point], targets });
    await harness.settled();
    const at = await harness.evaluate([point]);
    return [Math.abs(point.position[0] - x), Math.abs(point.position[1] - y), ...targets.map((value, axis) => Math.abs(value - at[axis]))];
  });

  off.forEach((distance) => assert.ok(distance < 1e-9, `${off}`));
  assert.equal(await page.evaluate(() => window.harness.session.pick([0, 0, 100], [0, 0, 1])), undefined);
  assert.ok(await worst() < 0.9);
  assert.deepEqual(errors, []);
});

test('a window sees what another has selected, until that one closes', async () => {
  const selected = (): Promise<number[][]> =>
    page.evaluate(() => [...window.harness.others.values()].map((other) => [...other.selected]));
  const other = await openPage(browser, server.origin);
  await other.page.evaluate((id) => window.harness.open(id), sceneId);
  await other.page.evaluate(() => window.harness.session.announce(Uint32Array.of(3, 1, 2)));
  await page.waitForFunction(() => window.harness.others.size === 1);

  assert.deepEqual(await selected(), [[3, 1, 2]]);
  await other.page.close();
  await page.waitForFunction(() => window.harness.others.size === 0);
});

test('a knot is inserted by another window: the cage has more points, every patch is where the definition says', async () => {
  const other = await openPage(browser, server.origin);
  await other.page.evaluate((id) => window.harness.open(id), sceneId);
  await other.page.evaluate(() => window.harness.session.insertKnot(0, 0.5));
  for (const each of [page, other.page]) {
    await each.waitForFunction(() => window.harness.session.lattice.count === 80);
    assert.ok(await worst(each) < 0.9);
  }

  assert.deepEqual([...errors, ...other.errors], []);
  await other.page.close();
});

test('where no WebSocket passes, gRPC-Web does the same', async () => {
  const context = await browser.newContext();
  await stopWebSockets(context);
  const walled = await context.newPage();
  await walled.goto(server.origin);
  await walled.evaluate((id) => window.harness.open(id), sceneId);
  await walled.evaluate(() => window.harness.drag(30, 5, 0.1));
  await walled.evaluate(() => window.harness.session.apply({ kind: 'move', indices: Uint32Array.of(9999), offset: [0, 0, 2] }));
  await walled.waitForFunction(() => window.harness.refused.length === 1);
  await walled.evaluate(() => window.harness.session.announce(Uint32Array.of(7)));
  await page.waitForFunction(() => [...window.harness.others.values()].some((other) => other.selected[0] === 7));

  assert.match(await walled.evaluate(() => window.harness.refused[0]), /9999/);
  await context.close();
});

test('for a mesh without room the oldest scenes are forgotten, none in vain; what is refused stays with the page', async (t) => {
  const storing = await storingPage(t);
  /** Which of meshes a to d and scenes 1 to 3 are there; in capitals what only the page has. */
  const there = (): Promise<string> => storing.evaluate(async () => {
    const { store } = window.harness;
    const found = [...'abcd'].map(async (id) =>
      (await store.keepsMesh(id)) ? id : (await store.mesh(id)) ? id.toUpperCase() : '');
    const scenes = [...'123'].map(async (id) => ((await store.scene(id)) ? id : ''));
    return (await Promise.all([...found, ...scenes])).join('');
  });
  const save = (meshes: [id: string, megabytes: number][], scenes: [id: string, mesh: string][]): Promise<string> =>
    storing.evaluate(async ([files, users]) => {
      const { store } = window.harness;
      try {
        for (const [id, megabytes] of files) {
          await store.saveMesh({ id, header: new Uint8Array(), content: new Blob([new Uint8Array(megabytes * 1e6)]) });
        }
        for (const [id, mesh] of users) {
          await store.saveScene({ id, mesh, bootId: '', request: new Uint8Array(), savedAt: Number(id) });
        }
        return '';
      } catch (error) {
        return (error as Error).message;
      }
    }, [meshes, scenes] as const);

  assert.equal(await save([['a', 4], ['b', 4], ['b', 4]], [['1', 'a'], ['2', 'b'], ['3', 'b']]), '');
  assert.equal(await there(), 'ab123');
  assert.equal(await save([['c', 3]], []), '');
  assert.equal(await there(), 'bc23');
  assert.equal(await save([['d', 8]], []), 'the browser has no room left for it'); // b and c together have 7
  assert.equal(await there(), 'bcD23');
  await storing.reload();
  assert.equal(await there(), 'bc23');
  await storing.evaluate(() => {
    const { now } = Date;
    Date.now = () => now() + 2 * 3600 * 1000; // of c no scene was made
    return window.harness.store.forgetOld();
  });
  assert.equal(await there(), 'b23');
});

test('what was dropped beside a mesh is kept with it, counts with it for room, and is forgotten with it', async (t) => {
  const storing = await storingPage(t);
  const keep = (mesh: string, megabytes: number): Promise<string> => storing.evaluate(async ([id, size]) => {
    const files = [new File([new Uint8Array(size * 1e6)], `${size} of ${id}.png`)];
    return window.harness.store.saveCompanions(id, files).then(() => '', (error: Error) => error.message);
  }, [mesh, megabytes] as const);
  const makeScene = (id: string, mesh: string, megabytes: number): Promise<void> => storing.evaluate(async ([scene, file, size]) => {
    const { store } = window.harness;
    await store.saveMesh({ id: file, header: new Uint8Array(), content: new Blob([new Uint8Array(size * 1e6)]) });
    await store.saveScene({ id: scene, mesh: file, bootId: '', request: new Uint8Array(), savedAt: Number(scene) });
  }, [id, mesh, megabytes] as const);
  const there = (): Promise<string[]> => storing.evaluate(async () =>
    (await Promise.all([...'abx'].map((id) => window.harness.store.companions(id)))).flat().map(({ name, size }) => `${name}: ${size}`));

  await makeScene('1', 'a', 2);
  assert.equal(await keep('a', 3), '');
  await makeScene('2', 'b', 1);
  assert.equal(await keep('b', 2), '');
  assert.equal(await keep('b', 5), ''); // in place of 2, and of a
  assert.deepEqual(await there(), ['5 of b.png: 5000000']);
  assert.equal(await storing.evaluate(() => window.harness.store.keepsMesh('a')), false);
  assert.equal(await keep('b', 11), 'the browser has no room left for it');
  assert.deepEqual(await there(), ['5 of b.png: 5000000']);
  assert.equal(await keep('x', 1), ''); // of a mesh that nobody has
  await storing.evaluate(() => window.harness.store.forgetOld());
  assert.deepEqual(await there(), ['5 of b.png: 5000000']);
});

test('a server that is killed and started again has the scene again', async () => {
  const points = await page.evaluate(() => Array.from(window.harness.session.lattice.points));
  await server.kill();
  await page.waitForFunction(() => window.harness.session.status.state === 'retrying');
  await server.restart();
  await page.waitForFunction(() => window.harness.session.status.state === 'restored', undefined, { timeout: 60_000 });

  assert.deepEqual(await page.evaluate(() => Array.from(window.harness.session.lattice.points)), points);
  await page.evaluate(() => window.harness.session.apply({ kind: 'move', indices: Uint32Array.of(21), offset: [0, 0.2, 0] }));
  assert.ok(await worst() < 0.9);
  await shot('restored');
});

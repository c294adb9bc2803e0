// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium while the server has no time: what a person holds does not wait for it.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { distance, type Vec3 } from '@src/lattice/vec';
import { followsDefinition, shownBy } from './definition';
import { CORNER, direct, errors, OBJ, openTorus, page, server, until, useStage } from './stage';
import { colourAt, controlPoint, frames, onScreen, placeOf, upperHandle } from './viewer_page';


/** Where the handles are in the world. */
function handles(): Promise<Vec3> {
  return page.evaluate(() => {
    const { gizmo } = window.latticed.scene as unknown as { gizmo: { standIn: { position: { toArray(): number[] } } } };
    return gizmo.standIn.position.toArray() as unknown as Vec3;
  });
}

/** Every point of the surface that is shown. */
async function surface(): Promise<string> {
  return String((await shownBy(page)).points);
}

useStage({
  begin: async () => {
    await openTorus();
    await page.evaluate(() => window.latticed.settings.set({ gizmo: 'none' }));
    await followsDefinition(page, OBJ);
  },
});

test('while the server stands still the cage and the handles follow the pointer, and then the surface does', async () => {
  const rest = await controlPoint(page, CORNER);
  const atRest = await surface();
  const [x, y] = await onScreen(page, CORNER);

  server.halt();
  await page.mouse.move(x, y);
  await page.mouse.down();
  const discs = [];
  for (const [right, down] of [[-30, 20], [-60, 40]]) {
    await page.mouse.move(x + right, y + down, { steps: 2 });
    const point = await controlPoint(page, CORNER);
    const [nowX, nowY] = await placeOf(page, point);
    assert.ok(Math.hypot(nowX - x - right, nowY - y - down) < 1, `${[nowX - x, nowY - y]} is not ${[right, down]}`);
    await frames(page);
    discs.push(await colourAt(page, point));
  }
  assert.deepEqual(discs[1], discs[0]);
  assert.ok(distance(await colourAt(page, rest), discs[0]) > 30, 'the disc is still where it was');
  await page.mouse.up();

  await page.evaluate(() => window.latticed.settings.set({ gizmo: 'move' }));
  await frames(page);
  const dragged = await controlPoint(page, CORNER);
  assert.ok(distance(await handles(), dragged) < 1e-9);
  const tip = await upperHandle(page, dragged);
  await page.mouse.move(...tip);
  await page.mouse.down();
  await page.mouse.move(tip[0], tip[1] - 40, { steps: 4 });
  const lifted = await controlPoint(page, CORNER);
  const across = Math.hypot(lifted[0] - dragged[0], lifted[1] - dragged[1]);
  assert.ok(across < 1e-9 && lifted[2] > dragged[2] + 0.05, `${lifted} from ${dragged}`);
  assert.ok(distance(await handles(), lifted) < 1e-9);
  await page.mouse.up();
  assert.equal(await surface(), atRest);

  server.goOn();
  const { id } = (await direct.scenes.listScenes({})).scenes[0];
  const corner = async (): Promise<number[]> => {
    const { lattice } = await direct.scenes.getLattice({ scene: id });
    return lattice!.controlPoints.slice(3 * CORNER, 3 * CORNER + 3);
  };
  await until(async () => String(await corner()) === String(lifted), async () => `the server has ${await corner()}, not ${lifted}`);
  await followsDefinition(page, OBJ);
  assert.deepEqual(await controlPoint(page, CORNER), lifted);
  assert.deepEqual(errors, []);
});

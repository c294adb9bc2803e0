// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which axis of a file is up, and how large it is: chosen in the dialog or said by the format, shown by the view, kept by the
// server for others, and written into exports.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { UpAxis } from 'latticed/v1/mesh_pb';
import type { Basis, Vec3 } from '@src/lattice/vec';
import { openPage } from '../support/browser';
import { GlbMaker } from '../support/glb';
import { browser, direct, errors, OBJ, page, press, useStage } from '../support/stage';
import { camera, createScene, dropFiles, frames, live, meshUploaded, saved } from '../support/viewer_page';

useStage();

const Y_UP: Record<string, Basis> = {
  '1': [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  '3': [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
  '7': [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
  'Control+1': [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
};

async function looks(key: string, wanted: Basis, of = page): Promise<void> {
  await of.keyboard.press(key);
  await frames(of);
  const { basis } = await camera(of);
  basis.forEach((axis: Vec3, i) => axis.forEach((x, j) => assert.ok(Math.abs(x - wanted[i][j]) < 1e-3, `${key}: ${axis}`)));
}

async function unitsAtServer(): Promise<{ up: UpAxis | undefined; metersPerUnit: number | undefined }> {
  const scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  const { units } = await direct.scenes.getScene({ scene });
  return { up: units?.upAxis, metersPerUnit: units?.metersPerUnit };
}

const chosen = (): Promise<string | null> =>
  page.getByRole('radiogroup', { name: 'Up' }).locator('[aria-checked=true]').textContent();

test('an OBJ file has y up unless told otherwise; the choice is remembered', async () => {
  await dropFiles(page, [['torus.obj', OBJ]]);
  await meshUploaded(page);
  assert.equal(await chosen(), 'Y');
  await createScene(page, 'y');
  await live(page);

  for (const [key, basis] of Object.entries(Y_UP)) await looks(key, basis);
  assert.deepEqual(await unitsAtServer(), { up: UpAxis.Y, metersPerUnit: 0 });
  assert.match((await page.locator('.extent').textContent())!, /^2\.8 × 2\.8 × 0\.(8|799|801) units$/);

  await dropFiles(page, [['torus.obj', OBJ]]); // the same bytes: the same mesh, another scene
  await createScene(page, 'z');
  await live(page);
  await looks('1', [[1, 0, 0], [0, 0, 1], [0, -1, 0]]);
  assert.equal((await unitsAtServer()).up, UpAxis.Z);

  await dropFiles(page, [['torus.obj', OBJ]]);
  await meshUploaded(page);
  assert.equal(await chosen(), 'Z');
  await page.getByRole('button', { name: 'Cancel' }).click();
});

test('a GLB file has y up and metres, which nobody is asked for; another window shows it so', async () => {
  const glb = new GlbMaker();
  const primitive = glb.square();
  const file = glb.file({ scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], meshes: [{ primitives: [primitive] }] });
  await dropFiles(page, [['square.glb', file]]);
  await meshUploaded(page);
  assert.equal(await page.getByRole('radiogroup', { name: 'Up' }).count(), 0);
  await createScene(page);
  await live(page);

  for (const [key, basis] of Object.entries(Y_UP)) await looks(key, basis);
  assert.deepEqual(await unitsAtServer(), { up: UpAxis.Y, metersPerUnit: 1 });
  assert.equal(await page.locator('.extent').textContent(), '2 × 2 × 0 m');

  const other = await openPage(browser, page.url());
  await live(other.page);
  await looks('3', Y_UP['3'], other.page);
  await other.page.close();
  assert.deepEqual([errors, other.errors], [[], []]);
});

test('exports say which axis is up', async () => {
  await dropFiles(page, [['torus.obj', OBJ]]);
  await createScene(page, 'y');
  await live(page);
  for (const [format, words] of [['ply', /up \+y/], ['obj', /up \+y/], ['stl', /up \+y/], ['glb', /"upAxis":"y"/]] as const) {
    await press('Control+e');
    const [download] = await Promise.all([
      page.waitForEvent('download'), page.locator('.export-choice', { hasText: format.toUpperCase() }).click()]);
    assert.match((await saved(download)).toString('latin1').slice(0, 2000), words, format);
    await page.locator('.export').waitFor({ state: 'detached' });
  }
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A session of a newcomer, which README's moving picture shows: the bent beam, the divider, a plane of control points that is
// moved and turned. Its frames are LATTICED_SHOTS/session_*.png; client/web/README.md says how to join them.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots;
// LATTICED_FILM: takes all frames of the film, otherwise few.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { errors, page, press, shot, until, useStage } from '../support/stage';
import { changesView, frames, live, onScreen } from '../support/viewer_page';

const isFilm = process.env['LATTICED_FILM'] !== undefined;
const STEPS = isFilm ? 12 : 3;

useStage({ context: { viewport: { width: 880, height: 560 }, colorScheme: 'dark' } });

let frame = 0;

/** Draws what has changed, and takes the next frame. */
async function film(times = 1): Promise<void> {
  await frames(page);
  for (let i = 0; i < (isFilm ? times : 1); ++i) await shot(`session_${String(frame++).padStart(3, '0')}`);
}

/** Moves the pointer from a place to another, a frame for each step. */
async function glide([fromX, fromY]: readonly [number, number], [toX, toY]: readonly [number, number]): Promise<void> {
  for (let i = 1; i <= STEPS; ++i) {
    const eased = (1 - Math.cos((Math.PI * i) / STEPS)) / 2;
    await page.mouse.move(fromX + (toX - fromX) * eased, fromY + (toY - fromY) * eased);
    await film();
  }
}

const points = (): Promise<string> => page.evaluate(() => window.latticed.scene!.session.lattice.points.join());

test('a newcomer compares both shapes, then moves and turns one end of the beam', async () => {
  await page.getByRole('button', { name: 'Bent beam' }).click();
  await live(page);
  await until(() => page.evaluate(() => window.latticed.scene!.session.surface.largestDifference > 0));
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await page.addStyleTag({ content: '.hud { display: none }' }); // its figures are of software drawing
  await film(6);

  const box = (await page.getByRole('slider', { name: 'Divider' }).boundingBox())!;
  const y = box.y + 120;
  const [left, middle, right] = [0.12, 0.5, 0.88].map((at) => 880 * at);
  await page.mouse.move(box.x + box.width / 2, y);
  await page.mouse.down();
  await glide([middle, y], [right, y]);
  await glide([right, y], [left, y]);
  await page.mouse.up();
  await film(4);

  await page.evaluate(() => window.latticed.settings.set({ compare: 'off', cage: true, gizmo: 'none' }));
  await changesView(page, 200, () => press('Home'));
  const last = await page.evaluate(() => window.latticed.scene!.session.lattice.count - 1);
  await page.mouse.click(...(await onScreen(page, last)));
  await press('Shift+U');
  await film(4);
  const before = await points();
  const from = await onScreen(page, last);
  await page.mouse.move(...from);
  await press('g');
  await glide(from, [from[0] - 110, from[1] - 110]);
  await page.mouse.click(from[0] - 110, from[1] - 110);
  const moved = await points();
  assert.notEqual(moved, before);
  const at = await onScreen(page, last);
  await page.mouse.move(at[0] + 80, at[1]);
  await press('r');
  await glide([at[0] + 80, at[1]], [at[0] + 60, at[1] + 60]);
  await page.mouse.click(at[0] + 60, at[1] + 60);
  assert.notEqual(await points(), moved);
  await film(8);
  assert.deepEqual(errors, []);
});

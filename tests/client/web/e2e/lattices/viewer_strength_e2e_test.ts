// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The strength of a scene in the viewer in Chromium: a slide of it is shown, sent and undone as one step.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openTorus, page, press, select, useStage } from '../support/stage';
import { controlPoint } from '../support/viewer_page';

const TOP = Array.from({ length: 16 }, (_, i) => 48 + i);  // the highest layer of 4 x 4 x 4

useStage({ context: { viewport: { width: 920, height: 560 } }, begin: openTorus });

/** The surface's largest coordinates, as drawn. */
function top(): Promise<number> {
  return page.evaluate(() => window.latticed.scene!.session.surface.bounds.max.z);
}

function inStep(): Promise<unknown> {
  return page.waitForFunction(() => window.latticed.scene!.session.isAt(1_000));
}

/** Waits until the surface is as high as this. It comes some time after the server's answer. */
function topComes(height: number, within: number): Promise<unknown> {
  return page.waitForFunction(([wanted, most]) =>
    Math.abs(window.latticed.scene!.session.surface.bounds.max.z - wanted) < most, [height, within] as const);
}

test('a slide shows a part of the deformation, moves no control point, and is one step of undo', async () => {
  const rest = await top();
  await select(...TOP);
  await press('g', 'z', '2', 'Enter');
  await inStep();
  await page.waitForFunction((least) => window.latticed.scene!.session.surface.bounds.max.z > least, rest + 0.3);
  const whole = await top(), before = await controlPoint(page, TOP[0]!);
  const slider = page.getByRole('slider', { name: 'Strength', exact: true });

  await slider.focus();
  await slider.fill('0.5');
  await inStep();

  await topComes((rest + whole) / 2, 0.02 * (whole - rest));
  assert.deepEqual(await controlPoint(page, TOP[0]!), before);
  assert.equal(await page.evaluate(() => window.latticed.scene!.session.lattice.strength), 0.5);
  await page.getByText('50 %').waitFor();
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await page.getByText('100 %').waitFor();
  await inStep();
  await topComes(whole, 0.05 * (whole - rest));
});

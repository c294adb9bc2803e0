// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Constraints in the viewer in Chromium: the volume is shown and kept, points are held and shown as such.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openTorus, page, press, select, useStage } from './stage';
import { controlPoint } from './viewer_page';

const POINT = 21;

useStage({ context: { viewport: { width: 920, height: 560 } }, begin: openTorus });

function volume(): Promise<number> {
  return page.evaluate(() => window.latticed.scene!.session.measureVolume());
}

function constraintsCome(kept: boolean, held: number): Promise<unknown> {
  return page.waitForFunction(([k, h]) => {
    const { session } = window.latticed.scene!;
    return (session.constraints.volume !== undefined) === k && session.held.size === h;
  }, [kept, held] as const);
}

test('the volume is shown, and kept while the switch is on', async () => {
  await page.getByText(/^Volume -?\d/).waitFor();
  const rest = await volume();
  await page.getByText('Keep volume', { exact: true }).click();
  await constraintsCome(true, 0);
  await select(POINT);

  await press('g', '1', 'Enter');

  await page.waitForFunction(() => window.latticed.scene!.session.isAt(1_000));
  assert.ok(Math.abs((await volume()) / rest - 1) < 1e-12);
  await page.getByText('Keep volume', { exact: true }).click();
  await constraintsCome(false, 0);
});

test('held points stay where they are', async () => {
  await select(POINT);
  await page.getByRole('button', { name: 'Hold selected' }).click();
  await constraintsCome(false, 1);
  await page.getByText('Held control points: 1').waitFor();
  const before = await controlPoint(page, POINT);

  await press('g', '1', 'Enter');

  assert.deepEqual(await controlPoint(page, POINT), before);
  await page.getByRole('button', { name: 'Release all' }).click();
  await constraintsCome(false, 0);
});

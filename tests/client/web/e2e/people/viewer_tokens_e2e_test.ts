// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the viewer in Chromium shows and says without a token, with one that may only look, and by a link to a scene that is gone.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import type { Page } from 'playwright-core';
import { distance } from '@src/lattice/vec';
import { openPage } from '../support/browser';
import { allPoints, browser, CORNER, openTorus, page, server, shot, until, useStage } from '../support/stage';
import { TOKENS, tokenOptions } from '../support/tokens';
import { camera, dropFiles, live, onScreen } from '../support/viewer_page';

const folder = mkdtempSync(join(tmpdir(), 'latticed-viewer-'));

/** Presses at a place, moves up and releases. */
async function dragUp(of: Page, [x, y]: readonly [number, number]): Promise<void> {
  await of.mouse.move(x, y);
  await of.mouse.down();
  await of.mouse.move(x, y - 40, { steps: 4 });
  await of.mouse.up();
}

useStage({
  serverOptions: tokenOptions(folder),
  address: () => `${server.origin}/#token=${TOKENS.edit}`,
  begin: () => openTorus(),
});
after(() => rmSync(folder, { recursive: true }));

test('without a token the page says that one is wanted', async () => {
  const { page: stranger } = await openPage(browser, server.origin);

  await stranger.locator('[data-sample=slab]').click();

  await stranger.locator('.fit .error').getByText('The server needs a token').waitFor();
  await stranger.close();
});

test('a link to a scene that is not there is said on the page', async () => {
  const { page: lost } = await openPage(browser, `${server.origin}/?scene=0123456789abcdef0123456789abcdef#token=${TOKENS.edit}`);

  await lost.locator('.toast-error').getByText(/^The scene 0123456789abcdef0123456789abcdef could not be opened\. /).waitFor();
  await shot('viewer_no_scene', lost);
  assert.ok(await lost.getByRole('button', { name: 'Open a mesh' }).isVisible());
  await lost.close();
});

test('a token that may only look sees the scene, cannot edit and is told so; of the heat map it is told what that asks', async () => {
  const { page: looker } = await openPage(browser, `${server.origin}/${new URL(page.url()).search}#token=${TOKENS.read}`);
  await live(looker);
  const before = await allPoints(looker);
  const said = 'The token of this page only allows to watch this scene, not to edit it';
  await looker.locator('.hint').getByText(said).waitFor();

  for (const key of ['a', 'g', 'z', '1', 'Enter', 'k', 'Control+z']) await looker.keyboard.press(key);
  await dragUp(looker, await onScreen(looker, CORNER)); // an orbit, or nothing
  assert.deepEqual(await allPoints(looker), before);
  assert.equal(await looker.locator('.toast, dialog[open]').count(), 0);
  assert.ok(await looker.getByRole('toolbar', { name: 'Tools' }).getByRole('button', { name: /^Undo/ }).isDisabled());
  await dropFiles(looker, [['lattice.json', '{}']]);
  await looker.locator('.toast-error').getByText('The token of this page only allows to watch the scene.').waitFor();
  await looker.keyboard.press('n'); // opens the panel
  await looker.getByLabel('Colour', { exact: true }).selectOption('displacement');

  const words = 'Displacement, knot boxes and rest shape cannot be shown. ' +
    'The token of this page does not allow that: it needs the role "edit".';
  await looker.locator('.toast-error').getByText(words).waitFor();
  await looker.close();
});

test('a token that may only look suffices to follow somebody, who sees no dot for it', async () => {
  const { page: looker, errors: lookerErrors } = await openPage(browser, `${server.origin}/${new URL(page.url()).search}#token=${TOKENS.read}`);
  await live(looker);
  await looker.locator('.person:enabled').click();
  for (const key of ['7', '3']) {
    await page.keyboard.press(key);
    const { position } = await camera(page);
    await until(async () => distance((await camera(looker)).position, position) < 1e-3);
  }
  assert.equal(await page.locator('.person').count(), 0);
  assert.deepEqual(lookerErrors, []);
  await looker.close();
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Links that the viewer makes, and what those who open them may do.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import type { Page } from 'playwright-core';
import { openPage } from '../support/browser';
import { allPoints, browser, CORNER, errors, openTorus, page, server, shot, until, useStage } from '../support/stage';
import { TOKENS, tokenOptions } from '../support/tokens';
import { live } from '../support/viewer_page';

const folder = mkdtempSync(join(tmpdir(), 'latticed-viewer-'));

useStage({
  serverOptions: tokenOptions(folder),
  address: () => `${server.origin}/#token=${TOKENS.edit}`,
  begin: async () => {
    await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
    await openTorus();
  },
});
after(() => rmSync(folder, { recursive: true }));

async function openShareDialog(): Promise<void> {
  await page.evaluate(() => window.latticed.commands.get('share').run());
  await page.getByRole('dialog', { name: 'Share' }).waitFor();
  await page.locator('.shares[aria-busy=false]').waitFor({ state: 'attached' });
}

/** Makes a link in the open dialog. */
async function madeLink(may: 'Watch' | 'Edit'): Promise<string> {
  const before = await page.locator('.shares li').count();
  await page.getByRole('radio', { name: may }).click();
  await page.getByRole('button', { name: 'Make a link' }).click();
  await until(async () => (await page.locator('.shares li').count()) === before + 1);
  await page.getByText('The link is copied. It is shown only once.').waitFor();
  const link = await page.getByLabel('Link', { exact: true }).inputValue();
  assert.equal(await page.evaluate(() => navigator.clipboard.readText()), link);
  assert.match(link, /\/\?scene=[0-9a-f]{32}#token=share-[0-9a-f]{16}-[0-9a-f]{64}$/);
  return link;
}

async function moveCorner(of: Page): Promise<void> {
  await of.bringToFront();
  await of.evaluate((corner) => window.latticed.scene!.editor.selection.select([corner]), CORNER);
  await of.keyboard.press('g');
  await of.keyboard.type('1');
  await of.keyboard.press('Enter');
}

test('a link to watch opens the scene, and edits nothing; one to edit edits; a revoked one is closed', async () => {
  await openShareDialog();
  const watching = await madeLink('Watch');
  const editing = await madeLink('Edit');
  await shot('share');

  const { page: watcher } = await openPage(browser, watching);
  await live(watcher);
  const { page: editor, errors: editorErrors } = await openPage(browser, editing);
  await live(editor);
  assert.equal(await watcher.evaluate(() => window.latticed.scene?.session.mayEdit), false);
  const before = await allPoints(watcher);
  await moveCorner(editor);
  await until(async () => String(await allPoints(page)) !== String(before));
  await until(async () => String(await allPoints(watcher)) === String(await allPoints(page)));
  assert.deepEqual(editorErrors, []);

  await page.bringToFront();
  await page.locator('.shares li').filter({ hasText: 'Edit until' }).getByRole('button').click();
  await until(async () => (await page.locator('.shares li').count()) === 1);
  await until(() => editor.evaluate(() => window.latticed.scene?.session.status.state === 'token'));
  await shot('share-revoked', editor);
  assert.equal(await watcher.evaluate(() => window.latticed.scene?.session.status.state), 'live');
  await page.getByRole('button', { name: 'Close' }).click();
  assert.deepEqual(errors, []);
  for (const guest of [watcher, editor]) await guest.close();
});

test('a guest makes no links', async () => {
  await openShareDialog();
  const link = await madeLink('Edit');
  const { page: guest } = await openPage(browser, link);
  await live(guest);
  assert.equal(await guest.getByRole('button', { name: 'Share…' }).isDisabled(), true);
  await guest.close();
});

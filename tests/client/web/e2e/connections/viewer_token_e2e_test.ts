// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium when its token ends: JSON web tokens of a few seconds, and one that is no token.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { createSign, generateKeyPairSync } from 'node:crypto';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { openPage } from '../support/browser';
import { keepToasts } from '../support/restarts';
import { browser, CORNER, direct, errors, moveCorner, openTorus, page, pointAtServer, revision, server, shot, until, useStage } from '../support/stage';
import { controlPoint, live, pointComesTo } from '../support/viewer_page';

const LEEWAY_S = 30; // by which the server takes a token for longer than it says
const ASKS = 'The token of this page has expired, or is not valid. What you edit waits here for another one.';

const folder = mkdtempSync(join(tmpdir(), 'latticed-tokens-'));
after(() => rmSync(folder, { recursive: true }));
const { publicKey, privateKey } = generateKeyPairSync('rsa', { modulusLength: 2048 });
writeFileSync(join(folder, 'keys.json'), JSON.stringify({ keys: [{ ...publicKey.export({ format: 'jwk' }), kid: 'k', alg: 'RS256', use: 'sig' }] }));

/** A token that the server takes for so many seconds. */
function tokenFor(seconds: number, role = 'edit'): string {
  const part = (value: object): string => Buffer.from(JSON.stringify(value)).toString('base64url');
  const exp = Date.now() / 1000 - LEEWAY_S + seconds;
  const signed = `${part({ alg: 'RS256', kid: 'k' })}.${part({ iss: 'i', aud: 'latticed', sub: 'ada', role, exp })}`;
  return `${signed}.${createSign('RSA-SHA256').update(signed).sign(privateKey).toString('base64url')}`;
}

useStage({
  serverOptions: ['--jwks-file', join(folder, 'keys.json'), '--jwt-issuer', 'i', '--jwt-audience', 'latticed'],
  address: () => `${server.origin}/#token=${tokenFor(3600)}`,
  begin: async () => {
    direct.useToken(tokenFor(3600, 'admin'));
    await openTorus(1);
  },
});

async function give(token: string): Promise<void> {
  await page.getByLabel('New token').fill(token);
  await page.getByRole('button', { name: 'Go on' }).click();
}

test('when the token ends the page asks for another; edits wait for it and then arrive, in order and once', async () => {
  const [first, [x, y, z]] = [await revision(), await controlPoint(page, CORNER)];
  await keepToasts(page);
  const short = tokenFor(12); // longer than a machine stalls before the edit arrives
  await page.evaluate((token) => (location.hash = `#token=${token}`), short); // as a link to the open page does
  await moveCorner([0.25, 0, 0]);
  await until(async () => (await revision()) === first + 1);

  await page.locator('.banner').getByText(ASKS).waitFor();
  await moveCorner([0, 0.25, 0]);
  await moveCorner([0, 0, 0.25]);
  await shot('viewer_token');
  await give('no token');
  await page.locator('.connection[data-state=retrying]').waitFor({ state: 'detached' });
  await page.locator('.banner').getByText(ASKS).waitFor();
  assert.equal(await revision(), first + 1);
  const link = `${server.origin}/#token=${tokenFor(3600)}`;
  await give(link);
  await live(page);

  await until(async () => String(await pointAtServer(CORNER)) === String([x + 0.25, y + 0.25, z + 0.25]));
  await pointComesTo(page, CORNER, [x + 0.25, y + 0.25, z + 0.25]);
  assert.equal(await revision(), first + 3);
  assert.ok(await page.locator('.banner').isHidden());
  assert.deepEqual(await page.evaluate(() => (window as unknown as { toasts: string[] }).toasts), []);
  assert.equal(await page.evaluate(() => location.hash), new URL(link).hash); // a reload keeps it
  assert.deepEqual(errors.filter((text) => !/401|WebSocket/.test(text)), []); // of the token that was none
});

test('a scene that is opened without a token that is valid is shown once there is one', async () => {
  const address = `${server.origin}/${new URL(page.url()).search}`;
  const { page: other } = await openPage(browser, `${address}#token=${tokenFor(-1)}`);
  await other.locator('.banner').getByText(ASKS).waitFor();

  await other.evaluate((token) => (location.hash = `#token=${token}`), tokenFor(3600, 'read'));
  await live(other);

  await other.locator('.hint').getByText('The token of this page only allows to watch this scene, not to edit it').waitFor();
  await other.evaluate((token) => (location.hash = `#token=${token}`), tokenFor(3600));
  await other.locator('.hint').getByText('Click or drag a control point').waitFor();
  await other.close();
});

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer in Chromium over TLS: gRPC-Web, the WebSocket of Deform, and downloads.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { get } from 'node:https';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { Certificate } from './certificate';
import { followsDefinition } from './definition';
import { tapSockets, type TappedSocket } from './socket_tap';
import { CORNER, errors, OBJ, openTorus, page, server, useStage } from './stage';
import { controlPoint } from './viewer_page';

const folder = mkdtempSync(join(tmpdir(), 'latticed-tls-'));
const certificate = new Certificate(folder);
let sockets: TappedSocket[];

/** A download by another client, which trusts the certificate alone. */
function download(path: string): Promise<Buffer> {
  return new Promise((resolve, reject) => {
    get(`${server.origin}${path}`, { ca: certificate.pem }, async (answer) => {
      const parts: Buffer[] = [];
      for await (const part of answer) parts.push(part as Buffer);
      assert.equal(answer.statusCode, 200);
      resolve(Buffer.concat(parts));
    }).on('error', reject);
  });
}

useStage({
  certificate,
  begin: async () => {
    sockets = tapSockets(page);
    await openTorus();
  },
});
after(() => rmSync(folder, { recursive: true }));

test('a page over TLS edits by a WebSocket over TLS, and the surface goes where the definition says', async () => {
  const [x, y, z] = await controlPoint(page, CORNER);

  await page.evaluate((index) => {
    const gesture = window.latticed.scene!.session.gesture();
    const indices = Uint32Array.of(index);
    for (let step = 1; step <= 8; ++step) gesture.update({ kind: 'move', indices, offset: [step / 16, 0, -step / 8] });
    gesture.commit();
  }, CORNER);

  assert.deepEqual(await controlPoint(page, CORNER), [x + 0.5, y, z - 1]);
  await followsDefinition(page, OBJ);
  assert.match(server.origin, /^https:/);
  assert.equal(sockets.length, 1);
  assert.match(sockets[0].address, /^wss:\/\/127\.0\.0\.1:.*\/ws\/latticed\.v1\.SceneService\/Deform\?/);
  assert.ok(sockets[0].events.some(({ case: kind }) => kind === 'editResult'));
  assert.deepEqual(errors, []);
});

test('what a page over TLS downloads is what another client gets: the surface with the edit', async () => {
  const scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);

  await page.keyboard.press('Control+e');
  const [saved] = await Promise.all([page.waitForEvent('download'), page.locator('.export-choice', { hasText: 'PLY' }).click()]);
  const bytes = readFileSync(await saved.path());
  const { segments, normals } = await page.evaluate(() => window.latticed.settings.value.view);

  assert.deepEqual(bytes, await download(`/export/${scene}.ply?segments=${segments}&normals=${normals}`));
  const patches = await page.evaluate(() => window.latticed.scene!.session.surface.patchCount);
  assert.match(bytes.toString('latin1', 0, bytes.indexOf('end_header')), new RegExp(`element face ${segments! ** 2 * patches}\n`));
  assert.deepEqual(errors, []);
});

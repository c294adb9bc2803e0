// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node opened_viewer.mjs WEB URL: the viewer's build folder, an address that names a scene
// Fails unless Chromium opens the address and shows that scene's surface, without an error of the page. Without
// Chromium it does nothing, or fails if LATTICED_REQUIRE_CHROMIUM is set. $CHROMIUM names another program.
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';

const [web, url] = process.argv.slice(2);
const executablePath = process.env.CHROMIUM || '/usr/bin/chromium';
const MOST_MS = 120_000; // drawing the first frame without a GPU is slow

async function openViewer() {
  const { chromium } = createRequire(join(resolve(web), 'package.json'))('playwright-core');
  const browser = await chromium.launch({
    executablePath,
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
  try {
    const page = await browser.newPage({ viewport: { width: 800, height: 600 } });
    const errors = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    await page.goto(url);
    const scene = new URL(url).searchParams.get('scene');
    const patches = await page.waitForFunction((id) => {
      const { session } = window.latticed?.scene ?? {};
      return session?.sceneId === id && session.surface.patchCount;
    }, scene, { timeout: MOST_MS });
    assert.deepEqual(errors, []);
    console.log(`${url}: ${await patches.jsonValue()} patches in Chromium`);
  } finally {
    await browser.close();
  }
}

if (existsSync(executablePath)) {
  await openViewer();
} else {
  console.log(`no ${executablePath}: the address is not opened in a browser`);
  process.exitCode = process.env.LATTICED_REQUIRE_CHROMIUM ? 1 : 0;
}

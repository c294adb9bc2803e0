// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node run_files.mjs NAME…: runs the tests of each NAME_e2e_test.ts, one file after the other, in one Chromium.
// Node needs a second of the processor to load Playwright, and Chromium two to start.
import { after, describe } from 'node:test';
import { closeBrowser } from './support/browser';

after(closeBrowser);
for (const name of process.argv.slice(2)) {
  const file = `./${name}_e2e_test.mjs`;
  describe(name, async () => void (await import(file)));
}

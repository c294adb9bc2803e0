// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node viewer_bench.mjs [FILE]
// Time from an edit to its pixels in Chromium on loopback, and where it goes, as a table in Markdown.
// Environment: as session_e2e_test.
import { writeFileSync } from 'node:fs';
import { cpus } from 'node:os';
import type { Page } from 'playwright-core';
import { launch, openPage } from './browser';
import type { Measured } from './page/harness';
import { ServerProcess } from './server_process';
import { torusObj } from './torus';

const LATTICE = 6;  // control points per axis, degree 2: 64 knot boxes, of which one point moves 27 at most
const MIDDLE = 2 + LATTICE * (2 + LATTICE * 2);
const MESHES = [[15, 11], [65, 23], [130, 50]] as const;  // around, across: some 1,000, 5,000 and 17,000 patches
const EDITS = 40;
const DRAWN = 12;  // software OpenGL is slow

function percentile(values: readonly number[], fraction: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(fraction * sorted.length))];
}

const ms = (value: number): string => value.toFixed(value < 10 ? 1 : 0);

async function row(page: Page, encoding: 'draco' | 'quantised' | 'raw', what: string, indices: number[]): Promise<string> {
  const measure = (steps: number, draw: boolean): Promise<Measured> =>
    page.evaluate(([points, count, drawn]) =>
      window.harness.measure(points as number[], count as number, drawn as boolean), [indices, steps, draw] as const);
  await measure(5, false);
  const written = await measure(EDITS, false);
  const drawn = await measure(DRAWN, true);
  const median = (of: (time: Measured['updates'][number]) => number): string => ms(percentile(written.updates.map(of), 0.5));
  const { patches } = await page.evaluate(() => ({ patches: window.harness.surface.patchCount }));
  const cells = [patches, encoding, what, ms(percentile(written.ms, 0.5)), ms(percentile(written.ms, 0.95)),
    median(({ times }) => times.server), median(({ times }) => times.transfer), median(({ times }) => times.decode),
    median(({ times }) => times.upload), ms(percentile(drawn.drawMs, 0.5)), ms(percentile(drawn.ms, 0.5)),
    (percentile(written.updates.map(({ bytes }) => bytes), 0.5) / 1e6).toFixed(2), (EDITS / written.seconds).toFixed(1)];
  return `| ${cells.join(' | ')} |`;
}

const server = await ServerProcess.start(process.env.LATTICED_PAGE!);
const browser = await launch();
const lines = [
  `${cpus()[0].model}, ${cpus().length} threads for server, browser and software OpenGL (480 x 360); Chromium ${browser.version()}.`,
  'Milliseconds, medians; edit to points is from the edit until its points are in the vertex buffer, of which server is',
  'evaluation and encoding, transfer from the first to the last message of the update, decode what remains after that.', '',
  '| patches | encoding | edit of | edit to points | p95 | server | transfer | decode | write | upload and draw | edit to pixels | MB | updates/s |',
  '|---|---|---|---|---|---|---|---|---|---|---|---|---|'];
try {
  for (const [around, across] of MESHES) {
    const { page } = await openPage(browser, server.origin);
    const scene = await page.evaluate(([obj, size]) => window.harness.makeScene(obj as string, size as number), [torusObj(around, across), LATTICE]);
    await page.evaluate((id) => window.harness.open(id), scene);
    for (const encoding of ['quantised', 'raw', 'draco'] as const) {  // the page begins with draco
      await page.evaluate(async (name) => {
        window.harness.updates.length = 0;
        window.harness.session.setView({ encoding: name });
        await window.harness.until(() => window.harness.updates.length > 0);
      }, encoding);
      const all = Array.from({ length: LATTICE ** 3 }, (_, i) => i);
      for (const [what, indices] of [['all points', all], ['one point', [MIDDLE]]] as const) {
        lines.push(await row(page, encoding, what, [...indices]));
        console.log(lines.at(-1));
      }
    }
    await page.close();
  }
} finally {
  await browser.close();
  await server.kill();
}
if (process.argv[2]) writeFileSync(process.argv[2], `${lines.join('\n')}\n`);

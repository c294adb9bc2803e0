// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Short runs of the viewer's benchmarks. Checks that they measure, not what they measure.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';

const run = promisify(execFile);
const NUMBERS_FROM = 4; // the columns before are mesh, patches, form and moved

test('the bench fills its table of every form of the points, with every part of the way to the pixels, and that of an orbit', async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'latticed-bench-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const file = join(folder, 'viewer.md');

  await run(process.execPath, ['tests/viewer_bench.mjs', '--markdown', file, '--mesh', 'knot', '--updates', '3', '--frames', '1', '--orbit', '1']);

  const [updates, orbits] = readFileSync(file, 'utf8').split('\n\n').slice(-2).map((table) =>
    table.trim().split('\n').map((line) => line.split('|').slice(1, -1).map((cell) => cell.trim())));
  const [header, , ...rows] = updates;
  assert.deepEqual(rows.map(([mesh, patches, form, moved]) => [mesh, patches, form, moved].join()),
    ['quantised', 'raw', 'draco', 'draco at 0.5 pixels', 'patches'].flatMap((form) =>
      ['all points', 'one point'].map((moved) => `knot.obj,1060,${form},${moved}`)));
  for (const row of rows) {
    assert.equal(row.length, header.length);
    assert.ok(row.slice(NUMBERS_FROM).every((cell) => Number.isFinite(Number.parseFloat(cell))), row.join());
    const [points, bytes, pixels] = ['edit to points', 'MB', 'edit to pixels'].map((name) => Number(row[header.indexOf(name)]));
    assert.ok(points > 0 && pixels > 0, row.join());
    assert.ok(row.includes('patches') ? bytes < 0.1 : bytes > 0, row.join()); // no bound changes where all points move alike
  }
  const [, , [mesh, triangles, framesPerSecond, drawn, ratio]] = orbits;
  assert.equal(mesh, 'knot.obj');
  assert.ok(Number(triangles) >= 1060 && Number(triangles) < 106_000, triangles); // by tolerance, which the page ends with
  assert.ok(Number(framesPerSecond) > 0 && Number(drawn) > 0 && Number(ratio) <= 1, orbits[2].join());
});

test('the decoders give the same points, and the bench fills its table of all ways to decode', async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'latticed-bench-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const file = join(folder, 'viewer.md');

  await run(process.execPath, ['tests/decode_bench.mjs', '--markdown', file, '--mesh', 'knot', '--rounds', '2']);

  const text = readFileSync(file, 'utf8');
  assert.match(text, /an update of knot.obj at 10 segments.*: 34 chunks,\n69960 points/);
  const rows = [...text.matchAll(/^\| (\w+, [\w ]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$/gm)];
  assert.deepEqual(rows.map(([, way]) => way),
    ['draco3d, loop', 'ours, loop', 'draco3d, one worker', 'ours, one worker', 'ours, two workers']);
  for (const [row, , least, median, each] of rows) assert.ok(0 < Number(least) && Number(least) <= Number(median) && Number(each) > 0, row);
  assert.equal(text.match(/: [\d.]+ of the least times, [\d.]+ of the medians\.$/gm)?.length, 3);
});

test('the benches say so where there is no such mesh', async () => {
  for (const bench of ['viewer_bench', 'decode_bench']) {
    await assert.rejects(run(process.execPath, [`tests/${bench}.mjs`, '--mesh', 'none']), /no such mesh/);
  }
});

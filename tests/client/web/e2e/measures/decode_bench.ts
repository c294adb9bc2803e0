// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node decode_bench.mjs [--markdown FILE] [--mesh NAME] [--rounds N]
// Measures in Chromium how long an update of 10 segments, 12 and 8 bits, smooth normals takes to decode, by draco3d and by our
// decoder: in the loop that a worker of the viewer runs, points copied out; and through the viewer's pool of one worker, and of two.
// The points are compared first. Adds a Markdown table to FILE. --mesh (fandisk.obj): knot, vase or fandisk.obj. --rounds (31): the
// ways take turns in each. Environment: LATTICED, LATTICECTL, CHROMIUM; LATTICED_SHARED as for viewer_bench.mjs; LATTICED_PAGE, the
// folder tests/page.
import assert from 'node:assert/strict';
import { appendFileSync } from 'node:fs';
import { parseArgs } from 'node:util';
import { Services } from '@src/intake/services';
import { fitLattice } from '@src/lattice/fitted_lattice';
import { vector } from '@src/wire/lattice_message';
import { LatticedServer } from '@src/wire/latticed_server';
import { MESHES, percentile, subjectOf, type Subject } from './bench_subject';
import { launch, openPage } from '../support/browser';
import { WAYS } from '../page/decode_meter';
import type {} from '../page/harness'; // window.measureDecode
import { ServerProcess } from '../support/server_process';

const { values: options } = parseArgs({ options: {
  markdown: { type: 'string' }, mesh: { type: 'string', default: 'fandisk.obj' }, rounds: { type: 'string', default: '31' },
} });

/** Uploads the mesh, and makes a scene of it under a lattice whose points have moved. */
async function bentScene(server: LatticedServer, { name, content, size }: Subject): Promise<string> {
  const services = new Services(server);
  const file = { name, format: 'obj', content: new Blob([new Uint8Array(content)]) } as const;
  const { id, bounds } = await services.upload(file, () => undefined, new AbortController().signal);
  const [min, max] = [vector(bounds?.min), vector(bounds?.max)];
  const lattice = fitLattice({ min, max }, { size, degree: [2, 2, 2], padding: 0.02 });
  const bend = 0.05 * Math.max(...max.map((value, axis) => value - min[axis]));
  lattice.points.forEach((x, i) => (lattice.points[i] = x + bend * Math.sin(5 * i * i + 1)));
  return services.createScene(id, { lattice, view: {} });
}

const mesh = MESHES.find(({ model, sample }) => options.mesh === (model ?? sample.name));
const rounds = Number(options.rounds);
if (!mesh || !(rounds > 0)) throw new Error('no such mesh, or nothing to measure');
const subject = subjectOf(mesh);
const server = await ServerProcess.start(process.env.LATTICED_PAGE!);
const browser = await launch();
try {
  const scene = await bentScene(new LatticedServer(server.origin), subject);
  const { page } = await openPage(browser, server.origin);
  const { chunks, points, bytes, differing, times } =
    await page.evaluate((of) => window.measureDecode(...of), [scene, rounds] as const);
  assert.equal(differing, 0, 'the decoders disagree');

  const least = times.map((of) => Math.min(...of));
  const median = times.map((of) => percentile(of, 0.5));
  const ratio = (slow: (typeof WAYS)[number], fast: (typeof WAYS)[number]): string => {
    const [by, of] = [WAYS.indexOf(slow), WAYS.indexOf(fast)];
    return `${slow} / ${fast}: ${(least[by] / least[of]).toFixed(2)} of the least times, ${(median[by] / median[of]).toFixed(2)} of the medians.`;
  };
  const lines = [
    `Chromium ${browser.version()}; an update of ${subject.name} at 10 segments, 12 and 8 bits, smooth normals: ${chunks} chunks,`,
    `${points} points, ${(bytes / 1e6).toFixed(2)} MB. ${rounds} rounds by turns.`, '',
    '| decoder | least, ms | median, ms | least, ns a point |', '|---|---|---|---|',
    ...WAYS.map((way, i) => `| ${[way, least[i].toFixed(1), median[i].toFixed(1), (least[i] * 1e6 / points).toFixed(1)].join(' | ')} |`), '',
    ratio('draco3d, loop', 'ours, loop'), ratio('draco3d, one worker', 'ours, one worker'), ratio('ours, one worker', 'ours, two workers')];
  console.log(lines.join('\n'));
  if (options.markdown) appendFileSync(options.markdown, `\n${lines.join('\n')}\n`);
} finally {
  await browser.close();
  await server.kill();
}

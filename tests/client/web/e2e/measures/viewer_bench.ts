// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node viewer_bench.mjs [--markdown FILE] [--mesh NAME] [--form NAME]… [--rounds N] [--updates N] [--frames N] [--orbit N]
// Measures the time from an edit to its pixels in the viewer in Chromium on loopback, while a person drags, and where
// the time goes; and the frames of an orbit. Adds two Markdown tables to FILE. --mesh takes one mesh alone: knot, vase or
// fandisk.obj. --form takes a form of the points, and may be repeated: quantised, raw, draco, "draco at 0.5 pixels", patches;
// without it all are taken. --rounds (1): how often the forms are measured, by turns. --updates (60) counts while the surface is
// hidden, --frames (12) while it is shown. --orbit (4): seconds. Environment: LATTICED, LATTICECTL, CHROMIUM; LATTICED_VIEWER, the
// folder of the viewer; LATTICED_SHARED, a folder with real meshes in models/. If a mesh is missing, a sample replaces it.
import { appendFileSync } from 'node:fs';
import { parseArgs } from 'node:util';
import type { Page } from 'playwright-core';
import { LatticedServer } from '@src/wire/latticed_server';
import { MESHES, percentile, subjectOf, type Subject } from './bench_subject';
import { launch, openPage } from '../support/browser';
import { DragMeter, type Measured } from './drag_meter';
import { ServerProcess } from '../support/server_process';
import { measureOrbit } from './orbit_meter';
import { createScene, dropFiles, live, meshUploaded } from '../support/viewer_page';

/** How points come. The last one is the viewer's default, with which the page begins. */
interface Form {
  readonly name: string;
  readonly encoding: 'quantised' | 'raw' | 'draco' | 'patches';
  readonly detail: 'segments' | 'tolerance';
}
const FORMS: readonly Form[] = [
  { name: 'quantised', encoding: 'quantised', detail: 'segments' },
  { name: 'raw', encoding: 'raw', detail: 'segments' },
  { name: 'draco', encoding: 'draco', detail: 'segments' },
  { name: 'draco at 0.5 pixels', encoding: 'draco', detail: 'tolerance' },
  { name: 'patches', encoding: 'patches', detail: 'tolerance' },
];
const VIEWPORT = { width: 480, height: 360 };
const SEGMENTS = 10;
const { values: options } = parseArgs({ options: {
  markdown: { type: 'string' }, mesh: { type: 'string' }, form: { type: 'string', multiple: true, default: FORMS.map(({ name }) => name) },
  rounds: { type: 'string', default: '1' }, orbit: { type: 'string', default: '4' },
  updates: { type: 'string', default: '60' },
  frames: { type: 'string', default: '12' }, // software OpenGL is slow
} });
const HIDDEN = { points: Number(options.updates), frames: 0 };
const SHOWN = { points: 0, frames: Number(options.frames) };

const ms = (value: number): string => value.toFixed(value < 10 ? 1 : 0);
const spread = (values: readonly number[]): string[] => [ms(percentile(values, 0.5)), ms(percentile(values, 0.95))];

/** Does what a person does: drops the mesh, fills in the numbers of control points, creates the scene. */
async function openSubject(page: Page, { name, content, size }: Subject): Promise<void> {
  await dropFiles(page, [[name, content]]);
  await meshUploaded(page);
  for (const [axis, count] of size.entries()) {
    await page.getByLabel(`Points along ${'uvw'[axis]}`).fill(`${count}`);
    await page.getByLabel(`Points along ${'uvw'[axis]}`).press('Tab');
  }
  await createScene(page);
  await live(page);
}

/** Changes the view, and waits until the whole surface has come in it. */
async function setForm(page: Page, { encoding, detail }: Form): Promise<void> {
  await page.evaluate(([name, by, segments]) => {
    const { settings, scene } = window.latticed;
    const { view, detail: before } = settings.value;
    if (name === view.encoding && by === before && by === 'tolerance') return Promise.resolve(); // it has come so
    return new Promise<void>((resolve) => {
      const end = scene!.session.on('update', ({ fullDetail }) => {
        if (!fullDetail) return;
        end();
        resolve();
      });
      settings.set({ detail: by, view: { ...view, segments, encoding: name } });
    });
  }, [encoding, detail, SEGMENTS] as const);
  if (encoding === 'patches') await page.waitForFunction(() => window.latticed.scene!.session.surface.certifiedError > 0); // its plan
}

const showSurface = (page: Page, surface: boolean): Promise<void> =>
  page.evaluate((shown) => window.latticed.settings.set({ surface: shown }), surface);

function cells(hidden: Measured, shown: Measured): string[] {
  const { updates } = hidden;
  const median = (of: (update: Measured['updates'][number]) => number): string => ms(percentile(updates.map(of), 0.5));
  return [...spread(hidden.points),
    median(({ times }) => times.server), median(({ times }) => times.transfer), median(({ times }) => times.decode),
    median(({ times }) => times.upload), (percentile(updates.map(({ bytes }) => bytes), 0.5) / 1e6).toFixed(2),
    (hidden.points.length / hidden.seconds).toFixed(1),
    ...spread(shown.toPixels), ms(percentile(shown.drawing, 0.5)), (shown.points.length / shown.seconds).toFixed(1)];
}

const meshes = MESHES.filter(({ model, sample }) => [undefined, model ?? sample.name].includes(options.mesh));
const forms = FORMS.filter(({ name }) => options.form.includes(name));
if (!meshes.length || !forms.length || !(HIDDEN.points > 0 && SHOWN.frames > 0)) throw new Error('no such mesh, or nothing to measure');
const server = await ServerProcess.start(process.env.LATTICED_VIEWER!);
const direct = new LatticedServer(server.origin);
const browser = await launch();
const lines = [
  `Software OpenGL; Chromium ${browser.version()}, a window of`,
  `${VIEWPORT.width} x ${VIEWPORT.height}. The viewer's own page: a mesh is dropped, what is selected follows the mouse (G), ${SEGMENTS} segments or 0.5 pixels.`, '',
  '| mesh | patches | form | moved | edit to points | p95 | server | transfer | decode | write | MB | updates/s | edit to pixels | p95 | drawing | updates/s, drawn |',
  '|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|'];
const orbits = ['', '| mesh | triangles | frames/s in an orbit | triangles then | pixels along a side then |', '|---|---|---|---|---|'];

async function measure(subject: Subject): Promise<void> {
  const { page } = await openPage(browser, server.origin, { smooths: true });
  await page.setViewportSize(VIEWPORT);
  await openSubject(page, subject);
  const meter = await DragMeter.of(page);
  const { scene, patches } = await page.evaluate(() => {
    const { session } = window.latticed.scene!;
    return { scene: session.sceneId, patches: session.surface.patchCount };
  });
  const [u, v, w] = subject.size;
  const all = Array.from({ length: u * v * w }, (_, i) => i);
  const upper = (u >> 1) + u * ((v >> 1) + v * (w - 1)); // in the middle of the uppermost plane
  for (const form of Array.from({ length: Number(options.rounds) }, () => forms).flat()) {
    await setForm(page, form);
    for (const [moved, indices] of [['all points', all], ['one point', [upper]]] as const) {
      const measured: Measured[] = [];
      for (const shown of [false, true]) {
        await showSurface(page, shown);
        measured.push(await meter.measure(indices, shown ? SHOWN : HIDDEN));
        await meter.reached(Number((await direct.scenes.getScene({ scene })).revision));
      }
      lines.push(`| ${[subject.name, patches, form.name, moved, ...cells(measured[0], measured[1])].join(' | ')} |`);
      console.log(lines.at(-1));
    }
  }
  const atRest = await page.evaluate(() => window.latticed.scene!.session.surface.triangles[0]!);
  const { framesPerSecond, triangles, pixelRatio } = await measureOrbit(page, Number(options.orbit));
  orbits.push(`| ${[subject.name, atRest, framesPerSecond.toFixed(1), triangles, pixelRatio].join(' | ')} |`);
  console.log(orbits.at(-1));
  await page.close();
}

try {
  for (const mesh of meshes) await measure(subjectOf(mesh));
} finally {
  await browser.close();
  await server.kill();
}
if (options.markdown) appendFileSync(options.markdown, `${[...lines, ...orbits].join('\n')}\n`);

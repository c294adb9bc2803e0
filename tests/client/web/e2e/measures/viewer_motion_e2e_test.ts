// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Frames of the viewer in Chromium while something moves, and at rest: triangles, time to full detail, smooth edges. With
// software drawing a surface of 310,000 triangles takes far longer than a frame may.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { differing, luminance, picture, type Picture } from '../support/picture';
import { errors, openTorus, page, press, setView, shot, useStage } from '../support/stage';
import { torusObj } from '../support/torus';
import { createScene, dropFiles, frames, onScreen, segmentsCome } from '../support/viewer_page';

const [AROUND, ACROSS] = [56, 28];
const FULL = 2 * AROUND * ACROSS * 100; // triangles
const REFINED_MS = 300;
const MOVES = 25;
const OTHERS = 1000; // triangles of other things

interface Frame {
  /** Milliseconds since the page was opened. */
  readonly at: number;
  readonly triangles: number;
  readonly isFine: boolean;
}

type Recorded = Window & { recorded: Frame[]; movedAt: number };

useStage({ context: { viewport: { width: 800, height: 600 }, colorScheme: 'dark', smooths: true } });

/** Records frames, and the time of the last motion: of the camera, or of control points. */
function record(): Promise<void> {
  return page.evaluate(() => {
    const { viewport, scene } = window.latticed;
    const own = window as unknown as Recorded;
    own.recorded = [];
    const moved = (): void => void (own.movedAt = performance.now());
    viewport.rig.controls.addEventListener('change', moved);
    scene!.session.on('points', moved);
    viewport.onDrawn(() => own.recorded.push({
      at: performance.now(), triangles: viewport.renderer.info.render.triangles, isFine: viewport.isFine,
    }));
  });
}

/** Moves the mouse around, then waits for full detail. Returns the milliseconds from the last motion until it is drawn. */
async function wave([x, y]: readonly [number, number], what: string): Promise<number> {
  await page.evaluate(() => ((window as unknown as Recorded).recorded = []));
  for (let i = 1; i <= MOVES; ++i) await page.mouse.move(x + 60 * Math.sin(i / 4), y + 40 * Math.sin(i / 3));
  await page.waitForFunction(() => window.latticed.viewport.isFine);
  const { recorded, movedAt } = await page.evaluate(() => {
    const { recorded: all, movedAt: last } = window as unknown as Recorded;
    return { recorded: all, movedAt: last };
  });
  const moving = recorded.filter(({ at }) => at <= movedAt);
  const refined = recorded.find(({ at, isFine }) => at > movedAt && isFine)!;
  const told = `${what}: frames of ${moving.map(({ triangles }) => triangles).join(' ')} triangles`;

  assert.ok(moving.length > 4, told);
  // On a busy machine moves come so far apart that there is rest between them.
  const coarse = moving.filter(({ triangles }) => triangles <= FULL / 4 + OTHERS);
  assert.ok(coarse.length > 0.6 * moving.length, told);
  assert.ok(refined.triangles >= FULL, `${what}: at rest ${refined.triangles}`);
  return refined.at - movedAt;
}

/** The times of three waves; on a busy machine they may come late, by as much again. */
async function assertRefined(place: readonly [number, number], what: string): Promise<void> {
  const times = [await wave(place, what), await wave(place, what), await wave(place, what)];
  assert.ok(Math.min(...times) < 2 * REFINED_MS, `${what}: full detail after ${times} ms`);
}

test('at rest, edges are smooth: pixels at the outline mix the surface and the background', async () => {
  await openTorus(4);
  const set = (surface: boolean): Promise<void> =>
    page.evaluate((shown) => window.latticed.settings.set({ surface: shown, cage: false, gizmo: 'none', shadow: false }), surface);
  await set(false);
  await frames(page);
  const empty = await picture(page);
  await page.evaluate(() => {
    const { viewport } = window.latticed;
    viewport.onDrawn(() => {
      if (!viewport.isSmooth) return;
      const gl = viewport.renderer.getContext();
      const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
      gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      Object.assign(window, { smooth: pixels });
    });
  });
  await set(true);
  await frames(page);
  await page.waitForFunction(() => window.latticed.viewport.isSmooth);
  const base64 = await page.evaluate(() => {
    let text = '';
    const { smooth } = window as unknown as { smooth: Uint8Array };
    for (let i = 0; i < smooth.length; i += 8192) text += String.fromCharCode(...smooth.subarray(i, i + 8192));
    return btoa(text);
  });
  await shot('viewer_smooth');
  const plain = await picture(page);
  const smooth: Picture = { ...plain, pixels: Buffer.from(base64, 'base64') };
  const covered = new Set(differing(plain, empty));
  const steps = [1, -1, plain.width, -plain.width];
  const edges = [...covered].filter((pixel) => steps.some((step) => !covered.has(pixel + step)));
  /** How much of a pixel the surface covers, by luminance: 0 to 1. */
  const share = (pixel: number): number =>
    (luminance(smooth, pixel) - luminance(empty, pixel)) / (luminance(plain, pixel) - luminance(empty, pixel));
  const mixed = edges.filter((pixel) => share(pixel) > 0.1 && share(pixel) < 0.9).length;

  assert.ok(edges.length > 500 && mixed > 0.3 * edges.length, `${mixed} of ${edges.length} pixels at the outline are mixed`);
  const inside = [...covered].filter((pixel) => steps.every((step) => covered.has(pixel + step)));
  const changed = inside.filter((pixel) => Math.abs(share(pixel) - 1) > 0.1).length;
  assert.ok(changed < 0.02 * inside.length, `${changed} of ${inside.length} pixels inside`);
});

test('an orbit of a large surface is drawn over fewer rows, and in full soon after; nothing is asked of the server', async () => {
  await dropFiles(page, [['torus.obj', torusObj(AROUND, ACROSS)]]);
  await createScene(page);
  await setView({ segments: 10 });
  await segmentsCome(page, 10);
  await page.evaluate(() => window.latticed.settings.set({ cage: true, shadow: true }));
  await frames(page);
  const segments = (): Promise<number> => page.evaluate(() => window.latticed.scene!.session.surface.layout!.segments);
  await record();

  await page.mouse.move(70, 380);
  await page.mouse.down();
  await assertRefined([70, 380], 'orbit');
  await page.mouse.up();

  assert.equal(await segments(), 10);
});

test('while control points move it is drawn over fewer rows too, and in full soon after', async () => {
  const last = await page.evaluate(() => window.latticed.scene!.session.lattice.count - 1);
  await page.evaluate((index) => window.latticed.scene!.editor.selection.select([index]), last);
  await frames(page);
  const [x, y] = await onScreen(page, last);
  await page.mouse.move(x, y);
  await press('g');
  await assertRefined([x, y], 'edit');
  await shot('viewer_refined');
  await press('Escape');
  await frames(page);
  assert.deepEqual(errors, []);
});

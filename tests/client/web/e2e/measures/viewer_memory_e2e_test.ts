// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory that the viewer's page takes in Chromium while a person works in it.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ignoreNetwork } from '../support/browser';
import { followsDefinition } from '../support/definition';
import { assertFlat } from './page_memory';
import { CORNER, errors, OBJ, openTorus, page, select, useStage } from '../support/stage';
import { torusObj } from '../support/torus';
import { createScene, dropFiles, frames, onScreen, segmentsCome } from '../support/viewer_page';

const A_FRAME = 4; // steps of a mouse, at 240 per second; the page gets them as one move
const INNER = 42; // moves the whole surface
const HANDLES = 10; // three.js uploads a handle when it is first drawn, which may be in the tenth gesture
const LATE_TEXTURES = 1; // that of frames without cavities, which are drawn where frames take long
const SMALL_OBJ = torusObj(3, 3);
const UPDATES = 5000; // an update may leave 400 bytes of objects
const WARM_UP = 2500; // updates until V8 takes no more memory: about 40 MB
const FRAME_MS = 200; // a slow screen: more frames would take longer than all updates

/**
 * The numbers of geometries and textures that three.js has on the GPU, once all that the page shows now has been drawn there,
 * also the pictures that smooth its edges.
 */
async function drawn(): Promise<{ geometries: number; textures: number }> {
  await page.waitForFunction(() => window.latticed.viewport.isSmooth);
  return page.evaluate(() => ({ ...window.latticed.viewport.renderer.info.memory }));
}

useStage({
  context: { viewport: { width: 480, height: 360 }, smooths: true }, // frames draw quickly
  begin: async () => {
    await openTorus();
    await select(CORNER);
    await frames(page);
  },
});

test('200 moves of the mouse and 400 steps of a drag leave what the page takes as it is, and the surface where the definition says', async () => {
  const mouse = await page.context().newCDPSession(page); // Playwright's own moves make more calls to the page
  const send = (type: 'mousePressed' | 'mouseMoved' | 'mouseReleased', x: number, y: number, buttons: number): Promise<unknown> =>
    mouse.send('Input.dispatchMouseEvent', { type, x, y, button: buttons ? 'left' : 'none', buttons, clickCount: 1 });
  /** Moves the mouse in loops from a place, over the handles if they are shown. Waits once per frame. */
  const around = async ([x, y]: readonly [number, number], steps: number, buttons: number): Promise<void> => {
    for (let step = 1; step <= steps; ++step) {
      const angle = (2 * Math.PI * step) / 96;
      const moved = send('mouseMoved', x - 60 * Math.sin(angle), y + 30 * Math.sin(2 * angle), buttons);
      if (step % A_FRAME === 0) await moved;
    }
  };
  /** Moves the mouse, then drags the corner, which ends somewhere else. */
  const work = async (moves: number, steps: number): Promise<void> => {
    await page.evaluate(() => window.latticed.settings.set({ gizmo: 'move' }));
    await around(await onScreen(page, CORNER), moves, 0);
    await page.evaluate(() => window.latticed.settings.set({ gizmo: 'none' })); // the point itself is dragged
    await frames(page);
    const place = await onScreen(page, CORNER);
    await send('mousePressed', ...place, 1);
    await around(place, steps, 1);
    await send('mouseReleased', ...place, 1);
    await frames(page);
  };
  await work(50, 100);
  const onGpu = await drawn();
  const seen = await page.evaluateHandle(() => {
    const counts = { moves: 0, updates: 0 };
    window.addEventListener('pointermove', () => ++counts.moves);
    window.latticed.scene!.session.on('update', () => ++counts.updates);
    return counts;
  });

  await assertFlat(page, () => work(200, 400));

  const { moves, updates } = await seen.jsonValue();
  assert.ok(moves >= 600 / A_FRAME && updates > 0, `${moves} moves, ${updates} updates`);
  const { geometries, textures } = await drawn();
  assert.ok(geometries <= onGpu.geometries + HANDLES, `${geometries} geometries on the GPU, ${onGpu.geometries} before`);
  assert.ok(textures <= onGpu.textures + LATE_TEXTURES, `${textures} textures on the GPU, ${onGpu.textures} before`);
  await followsDefinition(page, OBJ);
});

test('5,000 updates of the surface, beside cage, panel and head-up line, leave what the page takes as it is', async () => {
  /** A gesture in loops. Each step waits for an update that holds it or an earlier one. */
  const drag = (steps: number): Promise<{ received: number; frames: number; rate: number }> =>
    page.evaluate(async ([inner, count]) => {
      const { viewport, scene } = window.latticed;
      const { session } = scene!;
      const [indices, seen] = [Uint32Array.of(inner), { received: 0, frames: 0 }];
      let wake = (): void => {};
      const ends = [
        session.on('update', ({ patchesSent, msFromEdit }) => {
          if (patchesSent > 0) ++seen.received;
          if (msFromEdit !== undefined) wake();
        }),
        viewport.onDrawn(() => ++seen.frames)];
      const gesture = session.gesture();
      for (let step = 0; step < count; ++step) {
        const angle = (2 * Math.PI * step) / 60;
        const updated = new Promise<void>((resolve) => (wake = resolve));
        gesture.update({ kind: 'move', indices, offset: [Math.cos(angle), Math.sin(angle), Math.sin(2 * angle)] });
        await updated;
      }
      const rate = Number(document.querySelector('[data-hud=updates]')!.textContent);
      gesture.commit();
      for (const end of ends) end();
      return { ...seen, rate };
    }, [INNER, steps] as const);
  /** Sets the segments, and whether the surface is drawn: without a graphics card frames take most of the time. */
  const show = async (segments: number, surface: boolean): Promise<void> => {
    await page.evaluate(([n, isDrawn]) => {
      const { settings } = window.latticed;
      settings.set({ panel: true, surface: isDrawn, detail: 'segments', view: { ...settings.value.view, segments: n } });
    }, [segments, surface] as const);
    await segmentsCome(page, segments);
  };
  await dropFiles(page, [['small.obj', SMALL_OBJ]]);
  await createScene(page);
  await select(INNER);
  await page.evaluate((ms) => {
    window.requestAnimationFrame = (draw) => window.setTimeout(() => draw(performance.now()), ms);
  }, FRAME_MS);
  await show(1, false); // few points: what an update leaves does not depend on them
  await page.locator('.panel').waitFor();
  assert.ok(await page.evaluate(() => window.latticed.settings.value.cage));
  await ignoreNetwork(page);
  await drag(WARM_UP);
  const onGpu = await drawn();
  let seen = { received: 0, frames: 0, rate: 0 };

  await assertFlat(page, async () => (seen = await drag(UPDATES)));

  assert.ok(seen.received >= UPDATES && seen.frames > 10 && seen.rate > 0, JSON.stringify(seen));
  const { geometries, textures } = await drawn(); // where frames take long, what the last scene had may go only now
  assert.ok(geometries <= onGpu.geometries, `${geometries} geometries on the GPU, ${onGpu.geometries} before`);
  assert.ok(textures <= onGpu.textures, `${textures} textures on the GPU, ${onGpu.textures} before`);
  await show(2, true);
  await followsDefinition(page, SMALL_OBJ);
  assert.deepEqual(errors, []);
});

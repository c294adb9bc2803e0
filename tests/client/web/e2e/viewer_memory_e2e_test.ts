// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the viewer's page takes in Chromium while a person works in it.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { followsDefinition } from './definition';
import { assertFlat } from './page_memory';
import { CORNER, errors, OBJ, openTorus, page, select, useStage } from './stage';
import { torusObj } from './torus';
import { controlPoint, createScene, dropFiles, frames, onScreen, segmentsCome } from './viewer_page';

const A_FRAME = 4; // steps of a mouse, at 240 a second; the page hears of them as one move
const AN_UPDATE = 8; // steps after which an update is waited for, so that a slow machine's page does as much as a quick one's
const INNER = 42; // moves all of the surface
const SMALL_OBJ = torusObj(3, 3);
const UPDATES = 10_000; // each of which may leave 200 bytes of objects
const FRAME_MS = 200; // of a slow screen: more frames take longer than all of the updates


/** What three has on the GPU. */
function drawn(): Promise<unknown> {
  return page.evaluate(() => ({ ...window.latticed.viewport.renderer.info.memory }));
}

useStage({
  context: { viewport: { width: 480, height: 360 } }, // quick frames
  begin: async () => {
    await openTorus();
    await select(CORNER);
    await frames(page);
  },
});

test('200 moves of the mouse over the view, without a press, leave what the page takes as it is', async () => {
  const box = (await page.locator('canvas').boundingBox())!;
  const corner = await onScreen(page, CORNER);
  /** The same way each time, over the surface, a point, and the handles that it has. */
  const hover = async (rounds: number): Promise<void> => {
    for (let move = 0; move < 40 * rounds; ++move) {
      const angle = (2 * Math.PI * move) / 40;
      const [x, y] = [0.5 + 0.4 * Math.sin(3 * angle), 0.5 + 0.4 * Math.sin(2 * angle)];
      await page.mouse.move(...(move % 20 === 0 ? corner : [box.x + x * box.width, box.y + y * box.height] as const));
      if (move % 20 === 0) await frames(page); // the handle that is marked there is drawn
    }
  };
  await hover(1);
  const before = await drawn();

  await assertFlat(page, () => hover(5));

  assert.deepEqual(await drawn(), before);
});

test('1,000 steps of a drag by the mouse leave what the page takes as it is, and the surface where the definition says', async () => {
  await page.evaluate(() => {
    const counts = { moves: 0, updates: 0 };
    window.addEventListener('pointermove', () => ++counts.moves);
    window.latticed.scene!.session.on('update', () => ++counts.updates);
    window.latticed.settings.set({ gizmo: 'none' }); // the point itself is dragged
    Object.assign(window, { counts });
  });
  const counts = (): Promise<{ moves: number; updates: number }> =>
    page.evaluate(() => ({ ...(window as unknown as { counts: { moves: number; updates: number } }).counts }));
  /** Waits until the page has had more updates than that. */
  const another = (seen: number): Promise<void> =>
    page.evaluate(
      (updates) =>
        new Promise((resolve) => {
          const has = (): boolean => (window as unknown as { counts: { updates: number } }).counts.updates > updates;
          if (has()) return resolve();
          const end = window.latticed.scene!.session.on('update', () => {
            if (!has()) return;
            end();
            resolve();
          });
        }),
      seen,
    );
  /** Around and around from where the point is; it ends somewhere else. Playwright's own moves would ask the page for more. */
  const drag = async (steps: number): Promise<void> => {
    const mouse = await page.context().newCDPSession(page);
    const [x, y] = await onScreen(page, CORNER);
    const send = (type: 'mousePressed' | 'mouseMoved' | 'mouseReleased', step: number): Promise<unknown> => {
      const angle = (2 * Math.PI * step) / 96;
      const place = { x: x - 30 * Math.sin(angle), y: y + 15 * Math.sin(2 * angle) };
      return mouse.send('Input.dispatchMouseEvent', { type, ...place, button: 'left', buttons: 1, clickCount: 1 });
    };
    await send('mousePressed', 0);
    let seen = 0;
    for (let step = 1; step <= steps; ++step) {
      const moved = send('mouseMoved', step);
      if (step % A_FRAME === 0) await moved;
      if (step % AN_UPDATE === AN_UPDATE / 2) seen = (await counts()).updates;
      if (step % AN_UPDATE === 0) await another(seen);
    }
    await send('mouseReleased', steps);
    await mouse.detach();
  };
  await drag(100);
  const [before, onGpu, place] = [await counts(), await drawn(), await controlPoint(page, CORNER)];

  await assertFlat(page, () => drag(1000));

  const { moves, updates } = await counts();
  assert.ok(moves - before.moves >= 1000 / A_FRAME, `${moves - before.moves} moves`);
  assert.ok(updates - before.updates >= 1000 / AN_UPDATE, `${updates - before.updates} updates`);
  assert.deepEqual(await drawn(), onGpu);
  assert.notDeepEqual(await controlPoint(page, CORNER), place);
  await followsDefinition(page, OBJ);
  assert.deepEqual(errors, []);
});

test('10,000 updates of the surface, beside cage, panel and head-up line, leave what the page takes as it is', async () => {
  /** A gesture around and around, each of whose steps waits for the update that holds the one before. */
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
  /** The surface comes, and is drawn or not: frames take longer than all the rest without a graphics card. */
  const show = async (segments: number, surface: boolean): Promise<void> => {
    await page.evaluate(([n, isDrawn]) => {
      const { settings } = window.latticed;
      settings.set({ panel: true, surface: isDrawn, view: { ...settings.value.view, segments: n } });
    }, [segments, surface] as const);
    await segmentsCome(page, segments);
  };
  await dropFiles(page, [['small.obj', SMALL_OBJ]]);
  await createScene(page);
  await select(INNER);
  await page.evaluate((ms) => {
    window.requestAnimationFrame = (draw) => window.setTimeout(() => draw(performance.now()), ms);
  }, FRAME_MS);
  await show(1, false); // what stays of every update does not go with its points
  await page.locator('.panel').waitFor();
  assert.ok(await page.evaluate(() => window.latticed.settings.value.cage));
  await drag(300);
  const onGpu = await drawn();
  let seen = { received: 0, frames: 0, rate: 0 };

  await assertFlat(page, async () => (seen = await drag(UPDATES)));

  assert.ok(seen.received >= UPDATES && seen.frames > 10 && seen.rate > 0, JSON.stringify(seen));
  assert.deepEqual(await drawn(), onGpu);
  await show(2, true);
  await followsDefinition(page, SMALL_OBJ);
  assert.deepEqual(errors, []);
});

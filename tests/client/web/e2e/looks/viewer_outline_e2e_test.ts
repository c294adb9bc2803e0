// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The outline of the surface in the viewer in Chromium: no pixel there is darker or lighter than the surface beside it.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { contrast, differing, luminance, picture } from '../support/picture';
import { errors, page, setView, shot, useStage } from '../support/stage';
import { torusObj } from '../support/torus';
import { createScene, dropFiles, frames, segmentsCome } from '../support/viewer_page';

const MOST = 1.5; // the contrast of a pixel to the pixels of the surface around it
const REACH = 2; // pixels around

useStage({ context: { viewport: { width: 800, height: 600 }, colorScheme: 'light' } });

/** The specks: pixels whose contrast to each pixel of the surface around them is larger than MOST. `edges`: those at the outline. */
async function specks(): Promise<{ specks: number; edges: number }> {
  const show = async (surface: boolean): Promise<void> => {
    await page.evaluate((shown) => window.latticed.settings.set({ surface: shown, cage: false, gizmo: 'none', shadow: false }), surface);
    await frames(page);
  };
  await show(false);
  const empty = await picture(page);
  await show(true);
  const seen = await picture(page);
  const { width } = seen;
  const covered = new Set(differing(seen, empty));
  const around = Array.from({ length: (2 * REACH + 1) ** 2 }, (_, i) => (i % (2 * REACH + 1)) - REACH + width * (Math.floor(i / (2 * REACH + 1)) - REACH));
  const edges = [...covered].filter((pixel) => [1, -1, width, -width].some((step) => !covered.has(pixel + step)));
  const isSpeck = (pixel: number): boolean => {
    const beside = around.map((step) => pixel + step).filter((other) => other !== pixel && covered.has(other));
    const own = luminance(seen, pixel);
    return beside.length > 4 && beside.filter((other) => contrast(luminance(seen, other), own) <= MOST).length <= 2;
  };
  return { specks: edges.filter(isSpeck).length, edges: edges.length };
}

for (const [name, rings, sides, all] of [['coarse', 12, 8, [1, 4, 20]], ['fine', 96, 48, [4]]] as const) {
  test(`the outline of a ${name} torus has no specks, of ${all.join(', ')} segments, in three views`, async () => {
    await dropFiles(page, [['torus.obj', torusObj(rings, sides)]]);
    await page.getByLabel('Crease angle').fill('180'); // a facet seen edge-on may be as dark as a speck
    await createScene(page);
    for (const segments of all) {
      await setView({ segments });
      await segmentsCome(page, segments);
      for (const from of [[3, -4, 2.4], [1, -3, 0.4], [-2, 1, -3]] as const) {
        await page.evaluate((direction) => {
          window.latticed.viewport.rig.lookFrom(direction);
          window.latticed.scene!.frameAll();
        }, from);
        const found = await specks();
        await shot(`viewer_outline_${name}_${segments}`);
        assert.ok(found.edges > 500, `${found.edges} pixels`);
        assert.equal(found.specks, 0, `${segments} segments, from ${from}: ${found.edges} pixels at the outline`);
      }
    }
    assert.deepEqual(errors, []);
  });
}

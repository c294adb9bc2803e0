// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface in the viewer in Chromium: pulled where it can and where it cannot follow, and shaded by each kind of normals.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { latticeToJson } from '@src/wire/lattice_json';
import { distance, type Vec3 } from '@src/lattice/vec';
import { followsDefinition } from './definition';
import { plainSheetObj } from './sheet';
import { allPoints, errors, OBJ, page, setView, shot, until, useStage } from './stage';
import { colourAt, createScene, dropFiles, frames, latticeIn, live, placeOf } from './viewer_page';

/** Two planes at right angles, whose ridge goes along y. */
const ROOF = ['-1 -1 0', '-1 1 0', '0 -1 1', '0 1 1', '1 -1 0', '1 1 0'].map((at) => `v ${at}\n`).join('') + 'f 1 3 4 2\nf 3 5 6 4\n';


/** Looks from above at what is open, without its cage. */
async function lookFromAbove(): Promise<void> {
  await page.evaluate(() => {
    window.latticed.settings.set({ cage: false, gizmo: 'none', orthographic: true });
    window.latticed.viewport.rig.lookFrom([0, -1e-3, 1]);
    window.latticed.scene!.frameAll();
  });
  await frames(page);
}

/** Presses on the surface at a point of the world and moves by pixels. */
async function pull(from: Vec3, right: number, up: number): Promise<[number, number]> {
  const [x, y] = await placeOf(page, from);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + right, y - up, { steps: 4 });
  return [x, y];
}

/** The ends of the line to what is out of reach, in pixels of the page. */
function pullLine(): Promise<number[]> {
  return page.evaluate(() => {
    const line = document.querySelector('.pull-line line')!;
    const box = window.latticed.viewport.canvas.getBoundingClientRect();
    return ['x1', 'y1', 'x2', 'y2'].map((name, i) => Number(line.getAttribute(name)) + (i % 2 === 0 ? box.left : box.top));
  });
}

useStage({ context: { viewport: { width: 640, height: 480 } } });

test('what lies outside the lattice is out of reach of a pull: a line and words say how far, until Escape', async () => {
  await dropFiles(page, [['sheet.obj', plainSheetObj()]]);
  await createScene(page);
  const whole = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  const half = latticeIn([[0, -1.2, -1], [1.2, 0, 0], [0, 2.4, 0], [0, 0, 2]], 3, 2); // around the right half
  await dropFiles(page, [['half.json', latticeToJson(half)]]);
  await page.waitForFunction((id) => window.latticed.scene!.session.sceneId !== id, whole);
  await live(page);
  await lookFromAbove();
  await page.keyboard.press('p');

  const [x, y] = await pull([-0.6, 0.1, 0], 60, 40);
  await page.locator('.hint.running').getByText(/^Pull .*\((\S+)\) +out of reach by \1: outside the lattice$/).waitFor();
  await page.mouse.move(x + 30, y - 40);
  await page.locator('.hint.running').getByText(/\((\S+)\) +out of reach by \1:/).waitFor();
  await frames(page);

  assert.ok(await page.locator('.pull-line').isVisible());
  (await pullLine()).forEach((at, i) => assert.ok(Math.abs(at - [x, y, x + 30, y - 40][i]) < 1, `${i}: ${at}`));
  assert.ok(await page.locator('.transform-bar').isHidden());
  await shot('viewer_out_of_reach');
  await page.keyboard.press('Escape');
  await page.locator('.pull-line').waitFor({ state: 'hidden' });
  assert.equal(await page.locator('.hint').innerText(), 'Press on the surface and pull it');
  await page.mouse.up();
});

test('what the lattice holds comes along with a pull: words say how far, and nothing is out of reach', async () => {
  const rest = await allPoints();
  await page.evaluate(() => {
    const answered = new Promise((resolve) => // and not to the Escape before, which has moved nothing
      window.latticed.scene!.session.on('update', ({ msFromEdit, patchesSent }) =>
        msFromEdit !== undefined && patchesSent > 0 && resolve(undefined)));
    Object.assign(window, { answered });
  });

  await pull([0.6, 0.1, 0], 40, 30);
  await page.evaluate(() => (window as unknown as { answered: Promise<unknown> }).answered);
  await frames(page);

  assert.match(await page.locator('.hint.running').innerText(), /^Pull {2}\S+ {2}\S+ {2}\S+ {3}\(\S+\)$/);
  assert.ok(await page.locator('.pull-line').isHidden());
  await page.mouse.up();
  assert.equal(await page.locator('.hint').innerText(), 'Press on the surface and pull it');
  await page.waitForFunction((middle) => {
    const { points } = window.latticed.scene!.session.lattice;
    return Math.hypot(...middle.map((x, axis) => points[39 + axis] - x)) > 1e-3;
  }, rest.slice(39, 42));
  await page.keyboard.press('p');
});

/** The roof's colours: left and right of the ridge, and near the right eaves. */
async function roofColours(): Promise<Vec3[]> {
  const colours: Vec3[] = [];
  for (const x of [-0.04, 0.04, 0.9]) colours.push(await colourAt(page, [x, 0.1, 1 - Math.abs(x)]));
  return colours;
}

const EDGE = 30; // of 255 per channel, length of the three: neighbours that a person sees apart
const SAME = 6;

test('facets are flat with an edge between them, smooth normals hide the edge, and without normals facets are shaded', async () => {
  await dropFiles(page, [['roof.obj', ROOF]]);
  await createScene(page);
  await page.setViewportSize({ width: 1000, height: 600 }); // with room for the panel
  await page.evaluate(() => window.latticed.settings.set({ panel: true }));
  await setView({ segments: 6, normalBits: 12 });
  await lookFromAbove();
  const shades: Vec3[][] = [];
  for (const [mode, hasEdge] of [['smooth', false], ['facet', true], ['none', true]] as const) {
    await page.getByLabel('Normals', { exact: true }).selectOption(mode);
    await page.waitForFunction((are) => {
      const { material } = window.latticed.scene!.session.surface as unknown as { material: { defines: object } };
      return 'HAS_NORMALS' in material.defines === are;
    }, mode !== 'none');
    await until(async () => {
      const [left, right, eaves] = await roofColours();
      return hasEdge
        ? distance(left, right) > EDGE && distance(right, eaves) < SAME
        : distance(left, right) < SAME && distance(right, eaves) > EDGE;
    }, async () => `${mode}: ${(await roofColours()).join(' ')}`);
    shades.push(await roofColours());
    await shot(`viewer_roof_${mode}`);
  }
  const [, facet, none] = shades;
  facet.forEach((colour, i) => assert.ok(distance(colour, none[i]) < SAME, `${colour} and ${none[i]}`));
});

test('after an edit every point is where the definition says, in each encoding', async () => {
  await dropFiles(page, [['torus.obj', OBJ]]);
  await createScene(page);
  await setView({ segments: 3, normals: 'smooth' });
  await page.evaluate(() =>
    window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(21, 42, 63), offset: [0.5, 0.7, 0.9] }));
  for (const encoding of ['quantised', 'raw', 'draco'] as const) {
    await page.getByRole('combobox', { name: 'Encoding' }).selectOption(encoding);
    await page.waitForFunction((floats) => {
      const surface = window.latticed.scene!.session.surface;
      return (surface.grid?.step === 1) === floats;
    }, encoding === 'raw');
    await followsDefinition(page, OBJ);
  }
  assert.deepEqual(errors, []);
});

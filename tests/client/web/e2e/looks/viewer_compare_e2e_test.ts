// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The comparison with an ordinary lattice, which moves a mesh's vertices only: on the bent beam of the start page by pixels,
// and on a torus by numbers.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { distance, type Vec3 } from '@src/lattice/vec';
import { deformed, followsDefinition, shownBy } from '../support/definition';
import { sourcePlaces } from '../support/source_places';
import { CORNER, errors, OBJ, openTorus, page, press, setView, shot, until, useStage } from '../support/stage';
import { changesView, frames, live, segmentsCome } from '../support/viewer_page';

const TOP: Vec3 = [0.5, 0.5, 1];
const ORANGE = 40; // by so much red exceeds blue where the other shape is drawn over the surface

useStage({
  context: { viewport: { width: 1200, height: 800 } },
  begin: () => page.addStyleTag({ content: '.hud { display: none }' }), // its figures are of software drawing
});

const apart = (): Promise<number> => page.evaluate(() => window.latticed.scene!.session.surface.largestDifference);
const set = (settings: object): Promise<void> => page.evaluate((change) => window.latticed.settings.set(change), settings);

/** The number of pixels of the view that are not its background, without the shadow, left and right of a fraction of its width. */
function covered(at: number): Promise<[left: number, right: number]> {
  return page.evaluate((fraction) => {
    const { viewport, settings } = window.latticed;
    settings.set({ shadow: false });
    viewport.renderer.render(viewport.scene, viewport.rig.camera);
    settings.set({ shadow: true });
    const gl = viewport.renderer.getContext();
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const all = new Uint32Array(width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(all.buffer));
    const counts: [number, number] = [0, 0];
    all.forEach((pixel, i) => (counts[i % width < fraction * width ? 0 : 1] += Number(pixel !== all[0])));
    return counts;
  }, at);
}

async function coveredWith(divider: number): Promise<[left: number, right: number]> {
  await set({ divider });
  await frames(page);
  return covered(0.5);
}

test('the beam of the start page opens bent, beside its shape if only vertices moved', async () => {
  await page.getByRole('button', { name: 'Bent beam' }).click();
  await live(page);
  await until(async () => (await apart()) > 0);
  await frames(page);
  await shot('compare_split');

  const [exact, flat, both] = [await coveredWith(0), await coveredWith(1), await coveredWith(0.5)];

  assert.ok(Math.abs(exact[0] - flat[0]) > 500, `${exact} ${flat}`); // bent and flat faces have other outlines
  // The column at the divider may show both.
  assert.ok(Math.abs(both[0] - flat[0]) < 20 && Math.abs(both[1] - exact[1]) < 20, `${both} ${flat} ${exact}`);
  const largest = await apart(); // 18 quads of a beam of length 2
  assert.ok(largest > 0.04 && largest < 0.15, `${largest}`);
  assert.match((await page.locator('.compare-apart').textContent())!, /^up to 0\.\d+ apart \(\d\.\d % of the size\)$/);
  assert.deepEqual(errors, []);
});

test('the divider is dragged, and moved by arrow keys', async () => {
  const divider = page.getByRole('slider', { name: 'Divider' });
  const box = (await divider.boundingBox())!;
  await page.mouse.move(box.x + box.width / 2, box.y + 200);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 100, box.y + 200, { steps: 3 });
  await page.mouse.up();

  const dragged = await page.evaluate(() => window.latticed.settings.value.divider * window.latticed.viewport.size.width);
  assert.ok(Math.abs(dragged - (await page.evaluate(() => window.latticed.viewport.size.width / 2)) - 100) < 1, `${dragged}`);
  await press('Home');
  assert.equal(await divider.getAttribute('aria-valuenow'), '0');
  await press('ArrowRight');
  assert.equal(await divider.getAttribute('aria-valuenow'), '2');
  await press('End');
  assert.equal(await page.evaluate(() => window.latticed.settings.value.divider), 1);
});

test('D goes on: the other shape over the surface, then the surface alone', async () => {
  const exact = await coveredWith(0);
  await set({ divider: 0.5 });

  await changesView(page, 500, () => press('d'));
  await shot('compare_over');
  assert.equal(await page.locator('.compare-line').isVisible(), false);
  const counts = await page.evaluate((least) => {
    const { viewport } = window.latticed;
    viewport.renderer.render(viewport.scene, viewport.rig.camera);
    const gl = viewport.renderer.getContext();
    const all = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, all);
    return all.reduce((count, red, i) => count + Number(i % 4 === 0 && red - all[i + 2] > least), 0);
  }, ORANGE);
  assert.ok(counts > 2000, `${counts} orange pixels`);

  await changesView(page, 500, () => press('d'));
  assert.equal(await page.locator('.compare').isVisible(), false);
  assert.deepEqual(await covered(0.5), exact);
});

test('the heat map goes up to the largest distance of the two shapes, which follows the definition', async () => {
  await openTorus();
  await page.evaluate(([corner, offset]) => {
    window.latticed.settings.set({ colouring: 'difference' });
    window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(corner - 5, corner), offset });
  }, [CORNER, TOP] as const);
  await setView({ segments: 5 });
  await segmentsCome(page, 5);
  await followsDefinition(page, OBJ);
  await until(async () => (await apart()) > 0);

  const shown = await shownBy(page);
  const source = (await until(() => sourcePlaces(page, shown.topology, shown.spots, OBJ)))!;
  const flat = source.flat((vertex) => deformed(shown.lattice, vertex));
  const largest = Math.max(...source.places.map((place, i) => distance(deformed(shown.lattice, place), flat[i])));

  assert.ok(Math.abs((await apart()) - largest) < 1.5 * shown.step, `${await apart()} ${largest} ${shown.step}`);
  await frames(page);
  await shot('compare_heat');
  const legend = page.locator('.heat-legend');
  assert.match((await legend.textContent())!, /^vertices only to exact  0/);
  assert.ok(Math.abs(Number((await legend.locator('span').last().textContent())!) - largest) < 2 * shown.step);
  assert.deepEqual(errors, []);
});

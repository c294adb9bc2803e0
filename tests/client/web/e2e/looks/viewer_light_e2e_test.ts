// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The light of the viewer in Chromium, by the luminance of pixels: contrast, relief, materials.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Vec3 } from '@src/lattice/vec';
import { LIGHTS } from '@src/light/shading';
import { contrast, differing, luminance, picture, quantile, type Picture } from '../support/picture';
import { errors, openTorus, page, shot, until, useStage } from '../support/stage';
import { colourAt, createScene, dropFiles, frames, placeOf } from '../support/viewer_page';

const LEAST_CONTRAST = 3; // WCAG 2.2, 1.4.11: graphics that must be told apart

useStage({ context: { viewport: { width: 1000, height: 600 }, colorScheme: 'dark' }, begin: async () => {
  await page.addStyleTag({ content: '.hud { display: none }' }); // its figures are of software drawing
  await openTorus(10);
} });

async function set(settings: object): Promise<void> {
  await page.evaluate((change) => window.latticed.settings.set(change), settings);
  await frames(page);
}

for (const theme of ['dark', 'light'] as const) {
  test(`${theme}, in every light the surface stands out from the background and the cage from the surface, ${LEAST_CONTRAST} to 1`, async () => {
    await set({ theme, gizmo: 'none', through: false, shadow: false, surface: false, cage: false });
    const empty = await picture(page);
    for (const light of LIGHTS) {
      await set({ light, surface: true, cage: false });
      const surface = await picture(page);
      await set({ cage: true });
      const all = await picture(page);
      if (light === 'studio') await shot(`viewer_contrast_${theme}`);

      const covered = differing(surface, empty);
      const fromBackground = covered.map((pixel) => contrast(luminance(surface, pixel), luminance(empty, pixel)));
      const isCovered = new Set(covered);
      const cage = differing(all, surface).filter((pixel) => isCovered.has(pixel));
      const fromSurface = cage.map((pixel) => contrast(luminance(all, pixel), luminance(surface, pixel)));

      assert.ok(covered.length > 10_000 && cage.length > 400, `${covered.length} pixels, ${cage.length} of the cage`);
      const told = [fromBackground, fromSurface].map((ratios) => [0.1, 0.2, 0.5].map((share) => quantile(ratios, share).toFixed(2)).join(', '));
      // In the tenth that has less, hollows are dark; of the cage, the smooth edges of discs pass through the surface's grey.
      assert.ok(quantile(fromBackground, 0.1) >= LEAST_CONTRAST, `${light}, surface to background: a tenth, a fifth, half below ${told[0]}`);
      assert.ok(quantile(fromSurface, 0.2) >= LEAST_CONTRAST, `${light}, cage to surface: a tenth, a fifth, half below ${told[1]}`);
    }
    await set({ light: 'studio' });
  });
}

test('the panel has three materials besides the studio, each of its own colour, and the page remembers the choice', async () => {
  await set({ theme: 'dark', cage: false });
  const choice = page.getByRole('combobox', { name: 'Light' });
  const seen: Record<string, readonly number[]> = {};
  for (const light of LIGHTS) {
    await choice.selectOption(light);
    await frames(page);
    seen[light] = await colourAt(page, [0, -1.25, 0.3]);
    await shot(`viewer_light_${light}`);
  }

  const [{ clay, jade, steel }, studio] = [seen as Record<string, number[]>, seen['studio']!];
  assert.ok(clay![0]! > 1.4 * clay![2]!, `${clay}`);
  assert.ok(jade![1]! > 1.3 * jade![0]!, `${jade}`);
  assert.ok(Math.max(...steel!) < 1.3 * Math.min(...steel!) && Math.max(...studio) < 1.4 * Math.min(...studio), `${steel} ${studio}`);
  assert.equal(await page.evaluate(() => (JSON.parse(localStorage['latticed.settings']) as { light: string }).light), 'steel');
  await set({ light: 'studio' });
});

test('below the surface lies a shadow, on the ground of the axis that is up; none is seen from above or when it is off', async () => {
  const look = async (from: readonly number[], shadow: boolean): Promise<Picture> => {
    await page.evaluate((direction) => {
      window.latticed.viewport.rig.lookFrom(direction as [number, number, number]);
      window.latticed.scene!.frameAll();
    }, from);
    await set({ cage: false, surface: true, shadow });
    return picture(page);
  };
  const pixelsInShade = async (from: readonly number[]): Promise<number> => {
    const [without, withShadow] = [await look(from, false), await look(from, true)];
    return differing(withShadow, without).filter((pixel) => contrast(luminance(withShadow, pixel), luminance(without, pixel)) > 1.2).length;
  };
  await set({ theme: 'light' });

  assert.ok(await pixelsInShade([3, -4, 2.4]) > 3000);
  await shot('viewer_shadow');
  assert.equal(await pixelsInShade([0, -1e-3, 1]), 0, 'from above');
  assert.equal(await pixelsInShade([3, -4, -2.4]), 0, 'from below');

  await page.evaluate(() => window.latticed.scene!.setUnits({ ...window.latticed.scene!.units, up: 'y' }));
  assert.ok(await pixelsInShade([3, 2.4, 4]) > 3000, 'y up');
  await shot('viewer_shadow_y');
  assert.equal(await pixelsInShade([0, 1, 1e-3]), 0, 'y up, from above');
  await page.evaluate(() => window.latticed.scene!.setUnits({ ...window.latticed.scene!.units, up: 'z' }));
});

/** The faces of n x n quads over a parallelogram, after `before` vertices. */
function gridFaces(n: number, before: number): string[] {
  return Array.from({ length: n * n }, (_, i) => {
    const first = 1 + before + (i % n) + (n + 1) * Math.floor(i / n);
    return `f ${first} ${first + 1} ${first + n + 2} ${first + n + 1}`;
  });
}

/** Shows parallelograms of a corner and two sides, without a crease between them, and nothing else, from a direction. */
async function showQuads(quads: readonly (readonly [Vec3, Vec3, Vec3])[], from: Vec3): Promise<void> {
  const n = 8; // of each side
  const lines = quads.flatMap(([at, u, v], k) => [
    ...Array.from({ length: (n + 1) ** 2 }, (_, i) => [i % (n + 1), Math.floor(i / (n + 1))]).map(([a, b]) =>
      `v ${[0, 1, 2].map((axis) => at[axis]! + (u[axis]! * a!) / n + (v[axis]! * b!) / n).join(' ')}`),
    ...gridFaces(n, k * (n + 1) ** 2),
  ]);
  await dropFiles(page, [['quads.obj', lines.join('\n')]]);
  await createScene(page);
  await page.evaluate((direction) => {
    window.latticed.settings.set({ theme: 'dark', cage: false, gizmo: 'none', shadow: false, orthographic: true });
    window.latticed.viewport.rig.lookFrom(direction as [number, number, number]);
    window.latticed.scene!.frameAll();
  }, from);
  await frames(page);
}

test('along the sharp edges of a box no pixel is brighter than both faces, nor darker', async () => {
  const [x, y, z]: Vec3[] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  await showQuads([[[0, 0, 0], x, z], [[1, 0, 0], y, z], [[0, 0, 1], x, y]], [3, -4, 2.4]);
  const seen = await picture(page);
  await shot('viewer_box');
  const levelAt = ([px, py]: readonly [number, number]): number => seen.pixels[4 * (Math.round(px) + seen.width * (seen.height - 1 - Math.round(py))) + 1]!;
  const box = await page.evaluate(() => window.latticed.viewport.canvas.getBoundingClientRect().toJSON() as DOMRect);
  const placed = async (point: Vec3): Promise<[number, number]> => {
    const [px, py] = await placeOf(page, point);
    return [px - box.left, py - box.top];
  };
  // Each edge: one end, the other, a point on either face.
  const corner: Vec3 = [1, 0, 1];
  for (const [what, end, one, other] of [
    ['front', [1, 0, 0], [0.5, 0, 0.5], [1, 0.5, 0.5]], ['upper left', [0, 0, 1], [0.5, 0, 0.5], [0.5, 0.5, 1]],
    ['upper right', [1, 1, 1], [1, 0.5, 0.5], [0.5, 0.5, 1]],
  ] as readonly [string, Vec3, Vec3, Vec3][]) {
    const middle = await placed(corner.map((c, axis) => (c + end[axis]!) / 2) as unknown as Vec3);
    const sides = await Promise.all([one, other].map(async (face) => {
      const [fx, fy] = await placed(face);
      const [dx, dy] = [fx - middle[0], fy - middle[1]];
      const length = Math.hypot(dx, dy);
      assert.ok(length > 40, `${what}: ${length} pixels to the middle of the face`);
      return Array.from({ length: 38 }, (_, i) => levelAt([middle[0] + (dx * (i + 2)) / length, middle[1] + (dy * (i + 2)) / length]));
    }));
    const brightest = Math.max(...sides.map((levels) => levels.at(-1)!));
    assert.ok(Math.max(...sides.flat()) <= brightest + 4, `${what}: ${sides.join(' | ')}`);
    for (const levels of sides) assert.ok(Math.min(...levels) >= levels.at(-1)! - 6, `${what}: ${levels}`);
  }
});

test('a wall hides light from the floor beside it, as much from near as from far', async () => {
  await showQuads([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [0, 1, 0], [0, 0, 1]]], [1, -0.6, 1.2]);
  const darkening = async (): Promise<number> =>
    (await colourAt(page, [0.03, 0.5, 0]))[1] / (await colourAt(page, [0.5, 0.5, 0]))[1];
  const far = await darkening();
  await shot('viewer_wall');
  assert.ok(far > 0.5 && far < 0.93, `${far}`);

  await page.evaluate(() => {
    const { rig } = window.latticed.viewport;
    rig.camera.zoom *= 1.6;
    rig.camera.updateProjectionMatrix();
    window.latticed.viewport.invalidate();
  });
  await frames(page);
  const near = await darkening();
  assert.ok(Math.abs(near - far) < 0.04, `${near} of ${far}`);

  await page.evaluate(() => {
    const { surface } = window.latticed.scene!.session;
    surface.setDetail(0, 'none');
    surface.setDetail = () => undefined; // the samples drawn at rest set the finest detail
  });
  const quick = await darkening();
  assert.ok(quick > 0.97, `${quick} while it moves and frames take long`);
  await set({ orthographic: false, shadow: true });
});

test('a relief of 3 % of the size is seen: in light and shade, and its hollows are darker than its ridges', async () => {
  const COUNT = 40;
  const WIDTH = 1e5; // more than half floats hold
  const HEIGHT = 0.03 * WIDTH; // from hollow to ridge
  const along = Array.from({ length: COUNT + 1 }, (_, i) => i / COUNT);
  const vertices = along.flatMap((y) => along.map((x) => `v ${WIDTH * x} ${WIDTH * y} ${(HEIGHT / 2) * Math.cos(6 * Math.PI * x)}`));
  await dropFiles(page, [['relief.obj', [...vertices, ...gridFaces(COUNT, 0)].join('\n')]]);
  await createScene(page);
  await page.evaluate(() => {
    window.latticed.settings.set({ theme: 'dark', cage: false, gizmo: 'none', surface: false });
    window.latticed.viewport.rig.lookFrom([0, -1e-3, 1]);
    window.latticed.scene!.frameAll();
  });
  await frames(page);
  const empty = await picture(page);
  await set({ surface: true });
  const seen = await picture(page);
  await shot('viewer_relief');

  const lights = differing(seen, empty).map((pixel) => luminance(seen, pixel));
  const ratio = quantile(lights, 0.95) / quantile(lights, 0.05);
  assert.ok(ratio > 1.6, `light to shade ${ratio}`);
  const coloursOf = async (): Promise<Vec3[]> =>
    [await colourAt(page, [WIDTH / 2, WIDTH / 2, -HEIGHT / 2]), await colourAt(page, [WIDTH / 3, WIDTH / 2, HEIGHT / 2])];
  const [hollow, ridge] = await coloursOf();
  assert.ok(ridge[1] > 1.2 * hollow[1], `${ridge} on the ridge, ${hollow} in the hollow`); // both face the eye

  await set({ compare: 'split', divider: 0.05 });
  await until(() => page.evaluate(() => window.latticed.scene!.session.surface.isCompared));
  await frames(page);
  assert.deepEqual(await coloursOf(), [hollow, ridge], 'right of a divider');
  await set({ compare: 'off' });
  assert.deepEqual(errors, []);
});

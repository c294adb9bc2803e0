// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The view of the viewer in Chromium, and selection in it: cameras, looks, points that the surface hides.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { add, distance, type Basis, type Vec3 } from '@src/lattice/vec';
import { bytes as inUnits } from '@src/wire/words';
import { behindSurface } from './behind_surface';
import { followsDefinition } from '../support/definition';
import { allPoints, CORNER, errors, OBJ, page, press, select, selected, setView, shot, until, useStage } from '../support/stage';
import {
  camera, colourAt, controlPoint, createScene, dropFiles, frames, meshUploaded, onScreen, placeOf, pointComesTo,
} from '../support/viewer_page';

const INNER = [21, 22, 25, 26, 37, 38, 41, 42];


/** Selects with a box around the whole view. Returns the selection. */
async function boxOverAll(): Promise<number[]> {
  const { x, y, width, height } = (await page.locator('canvas').boundingBox())!;
  await press('b');
  await page.mouse.move(x + 2, y + 2);
  await page.mouse.down();
  await page.mouse.move(x + width - 2, y + height - 2, { steps: 3 });
  await page.mouse.up();
  await press('b');
  return selected();
}

/** Undoes the last edit, and waits until a control point is back at `place`. */
async function undo(place: Vec3, index = CORNER): Promise<void> {
  await press('Control+z');
  await pointComesTo(page, index, place);
}

/** Drags from an empty place to the right and down. */
async function dragEmpty(button: 'left' | 'right'): Promise<void> {
  await page.mouse.move(70, 380);
  await page.mouse.down({ button });
  await page.mouse.move(150, 410, { steps: 4 });
  await page.mouse.up({ button });
  await frames(page);
}

function assertNear(got: Vec3, wanted: Vec3, most: number, what: string): void {
  assert.ok(distance(got, wanted) < most, `${what}: ${got} is not ${wanted}`);
}

useStage({
  context: { viewport: { width: 640, height: 480 }, smooths: true },
  begin: async () => {
    await dropFiles(page, [['torus.obj', OBJ]]);
    await meshUploaded(page);
    await page.getByLabel('Degree along w').selectOption('1');
    await page.getByLabel('Padding').fill('25');
    await page.getByLabel('Padding').press('Tab');
    await createScene(page);
    await setView({ segments: 2 }); // frames draw quickly
  },
});

beforeEach(async () => {
  await page.evaluate(() => {
    const { settings, viewport, scene } = window.latticed;
    settings.set({ tool: 'select', gizmo: 'none', through: true, orthographic: false });
    viewport.rig.lookFrom([3, -4, 2.4]);
    scene!.editor.selection.none();
    scene!.frameAll();
  });
  await frames(page);
});

test('the lattice has the degrees and the padding of its dialog', async () => {
  const { degree, frame } = await page.evaluate(() => {
    const { degree: d, frame: f } = window.latticed.scene!.session.lattice;
    return { degree: d, frame: f };
  });

  assert.deepEqual(degree, [2, 2, 1]);
  assertNear(frame.origin, [-2.1, -2.1, -1.1], 1e-6, 'origin'); // radii 1 and 0.4; padding a quarter of 2.8
  assertNear(add(frame.u, add(frame.v, frame.w)), [4.2, 4.2, 2.2], 1e-6, 'edges');
});

const SIDES: Record<string, Basis> = {
  '1': [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  '3': [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
  '7': [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  'Control+1': [[-1, 0, 0], [0, 0, 1], [0, 1, 0]],
  'Control+3': [[0, -1, 0], [0, 0, 1], [-1, 0, 0]],
  'Control+7': [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
};

test('front, side, top and their opposites look along the axes; F brings what is selected to the middle, from there', async () => {
  const box = (await page.locator('canvas').boundingBox())!;
  const [a, b] = [await controlPoint(page, CORNER), await controlPoint(page, CORNER - 3)]; // a row's ends
  const middle: Vec3 = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2];

  for (const [key, wanted] of Object.entries(SIDES)) {
    await select();
    await press('Home', key);
    const { basis, position, target } = await camera(page);
    basis.forEach((axis, i) => assertNear(axis, wanted[i], 1e-3, `${key}, ${'right up back'.split(' ')[i]}`));
    const whole = distance(position, target);

    await select(CORNER, CORNER - 3);
    await press('f');
    const framed = await camera(page);
    framed.basis.forEach((axis, i) => assertNear(axis, wanted[i], 1e-3, `${key} F`));
    assertNear(framed.target, middle, 1e-9, `${key} F`);
    assert.ok(distance(framed.position, framed.target) < whole);
    const [mx, my] = await placeOf(page, middle);
    assert.ok(Math.hypot(mx - box.x - box.width / 2, my - box.y - box.height / 2) < 1, `${key}: ${[mx, my]}`);
    for (const index of [CORNER, CORNER - 3]) {
      const [x, y] = await onScreen(page, index);
      assert.ok(x > box.x && x < box.x + box.width && y > box.y && y < box.y + box.height, `${key}: ${[x, y]}`);
    }
  }
  await page.getByRole('button', { name: 'Look from −X' }).click();
  assertNear((await camera(page)).basis[2], [-1, 0, 0], 1e-3, 'the axes in the corner');
});

test('5 makes parallels stay parallel, shows the same part of the world, and goes back', async () => {
  await press('1');
  // The four corners of the front, then the corner of the back behind each.
  const corners = (): Promise<[number, number][]> => Promise.all([0, 3, 48, 51, 12, 15, 60, 63].map((i) => onScreen(page, i)));
  const gaps = (places: [number, number][]): number[] =>
    [0, 1, 2, 3].map((i) => Math.hypot(places[i][0] - places[i + 4][0], places[i][1] - places[i + 4][1]));
  const inPerspective = await corners();
  /** Pixels per unit across the line of sight, at the target. */
  const unit = async (): Promise<number> => {
    const { basis, target } = await camera(page);
    const [x, y] = await placeOf(page, target);
    const [u, v] = await placeOf(page, add(target, basis[0]));
    return Math.hypot(u - x, v - y);
  };
  const before = await unit();

  await press('5');
  const inParallel = await corners();
  const pixels = await unit();
  await page.mouse.move(320, 240);
  await page.mouse.wheel(0, -300);
  await page.waitForFunction(() => window.latticed.viewport.rig.camera.zoom > 1.01);
  const zoomed = await unit();
  await press('5');

  assert.ok(gaps(inPerspective).every((gap) => gap > 10), `${gaps(inPerspective)}`);
  assert.ok(gaps(inParallel).every((gap) => gap < 0.01), `${gaps(inParallel)}`);
  assert.ok(Math.abs(pixels / before - 1) < 1e-6, `${pixels} from ${before}`);
  assert.ok(zoomed > 1.01 * pixels);
  assert.ok(Math.abs((await unit()) / zoomed - 1) < 1e-6);
  assert.ok(await page.evaluate(() => !window.latticed.settings.value.orthographic));
});

test('empty space that is dragged turns the view, with the right button it shifts; nothing else moves', async () => {
  await select(CORNER);
  const points = await allPoints();
  const before = await camera(page);

  await dragEmpty('left');
  const turned = await camera(page);
  await dragEmpty('right');
  const shifted = await camera(page);

  assertNear(turned.target, before.target, 1e-9, 'target');
  assert.ok(distance(turned.basis[2], before.basis[2]) > 0.2);
  assert.ok(Math.abs(distance(turned.position, turned.target) / distance(before.position, before.target) - 1) < 1e-6);
  assertNear(shifted.basis[2], turned.basis[2], 1e-6, 'direction');
  assert.ok(distance(shifted.target, turned.target) > 0.2);
  assert.deepEqual(await selected(), [CORNER]);
  assert.deepEqual(await allPoints(), points);
});

test('visible only, a box takes exactly the points that the surface does not hide, and a click none behind it', async () => {
  const all = Array.from({ length: 64 }, (_, i) => i);
  const seen: string[] = [];
  for (const view of ['in perspective', 'parallel, from behind']) {
    if (seen.length > 0) {
      await press('5', 'Control+1');
      await dragEmpty('left');
      await press('Home');
    }
    const { hidden, shown } = await behindSurface(page);
    assert.ok(hidden.length >= 4 && hidden.length + shown.length >= 60, `${hidden}, ${shown}`);
    seen.push(`${hidden}`);

    if (seen.length < 2) assert.deepEqual(await boxOverAll(), all);
    await press('Alt+z');
    const taken = await boxOverAll();
    assert.deepEqual(taken.filter((i) => hidden.includes(i)), [], view);
    assert.deepEqual(shown.filter((i) => !taken.includes(i)), [], view);
    await page.mouse.click(...(await onScreen(page, hidden[0])));
    assert.ok(!(await selected()).includes(hidden[0]));
    if (seen.length < 2) await press('Alt+z');
  }
  assert.notEqual(seen[0], seen[1]);
  await shot('viewer_visible_only');

  // A point that comes out from behind the surface can be selected at once.
  const back = (await behindSurface(page)).hidden.at(-1)!; // in the uppermost plane
  await select(back);
  const rest = await controlPoint(page, back);
  await press('g', 'z', '.', '7', 'Enter');
  assert.ok((await boxOverAll()).includes(back));
  await undo(rest, back);
});

test('inner points that are hidden are neither drawn nor selected, until they are shown again', async () => {
  await page.evaluate(() => window.latticed.settings.set({ surface: false }));
  await frames(page);
  const at = await controlPoint(page, INNER[0]);
  const disc = await colourAt(page, at);

  await press('Shift+H');
  await frames(page);
  const empty = await colourAt(page, at);
  await page.getByText('0 of 64 control points, 8 hidden').waitFor({ state: 'attached' });
  const outer = Array.from({ length: 64 }, (_, i) => i).filter((i) => !INNER.includes(i));
  await press('a');
  assert.deepEqual(await selected(), outer);
  assert.deepEqual(await boxOverAll(), outer);
  await press('Control+i');
  assert.deepEqual(await selected(), []);
  await page.mouse.click(...(await onScreen(page, INNER[0])));
  assert.ok(!(await selected()).includes(INNER[0]));
  await press('Alt+h');
  await press('Alt+a', 'Control+i');
  assert.equal((await selected()).length, 64);
  await press('Alt+a');
  await frames(page);

  assert.deepEqual(await colourAt(page, at), disc);
  assertNear(disc, [0x0d, 0x0d, 0x16], 3, 'disc'); // linear colours are rounded to 8 bits
  assert.deepEqual(empty, [0xf3, 0xf5, 0xf9]);
  await page.evaluate(() => window.latticed.settings.set({ surface: true }));
});

test('bits and encoding of the panel are those of what comes, which the head-up line counts', async () => {
  const step = (): Promise<number> =>
    page.evaluate(() => window.latticed.scene!.session.surface.grid!.step);
  const waitForStep = (low: number, high: number): Promise<unknown> =>
    page.waitForFunction(([a, b]) => {
      const step = window.latticed.scene!.session.surface.grid!.step;
      return step > a && step < b;
    }, [low, high] as const);
  await press('n');
  const fine = await step();

  await page.getByRole('slider', { name: 'Position bits' }).fill('8');
  await waitForStep(8 * fine, 32 * fine); // 2^4 times the step of 12 bits
  await page.getByRole('slider', { name: 'Normal bits' }).fill('11');
  await page.waitForFunction(() => {
    const { uniforms } = window.latticed.scene!.session.surface as unknown as { uniforms: { octahedralMax: { value: number } } };
    return uniforms.octahedralMax.value === 2 ** 11 - 2; // by which the shader decodes normals
  });
  const idle = (): Promise<(string | null)[]> => // sliders that do not affect the stream are disabled
    page.locator('input[type=range]:disabled').evaluateAll((sliders) => sliders.map((slider) => slider.getAttribute('aria-label')));
  assert.deepEqual(await idle(), []);
  await page.getByRole('combobox', { name: 'Normals' }).selectOption('none');
  assert.deepEqual(await idle(), ['Normal bits']);
  await page.getByRole('combobox', { name: 'Normals' }).selectOption('smooth');
  await page.getByRole('combobox', { name: 'Encoding' }).selectOption('raw');
  assert.deepEqual(await idle(), ['Position bits', 'Normal bits']);
  await waitForStep(1 - 1e-9, 1 + 1e-9); // floats are in world units
  await page.locator('[data-hud=updates]').getByText(/^0$/).waitFor();
  await page.evaluate(() => {
    const seen: unknown[] = [];
    window.latticed.scene!.session.on('update', (info) => info.patchesSent > 0 && seen.push(info));
    const counts: string[] = []; // the line shows an update for a second only, which a slow machine may miss
    const count = document.querySelector('[data-hud=updates]')!;
    new MutationObserver(() => counts.push(count.textContent)).observe(count, { childList: true });
    Object.assign(window, { seen, counts });
  });
  const rest = await controlPoint(page, CORNER);
  await select(CORNER);
  await press('n', 'g', 'z', '1', 'Enter');
  await page.waitForFunction(() => {
    const { seen, counts } = window as unknown as { seen: unknown[]; counts: string[] };
    return seen.length > 0 && counts.some((count) => /^[1-9]/.test(count));
  });

  const { newest: { bytes, patchesSent, patchesAll }, told } = await page.evaluate(() => ({
    newest: (window as unknown as { seen: { bytes: number; patchesSent: number; patchesAll: number }[] }).seen.at(-1)!,
    told: ['bytes', 'patches'].map((name) => document.querySelector(`[data-hud=${name}]`)!.textContent),
  }));
  assert.deepEqual(told, [inUnits(bytes), `${patchesSent.toLocaleString('en')} / ${patchesAll.toLocaleString('en')}`]);
  assert.ok(patchesSent <= patchesAll && bytes >= patchesSent * 12, `${bytes} bytes of ${patchesSent} patches`);
  await page.locator('[data-hud=latency][title^="The newest: server "]').getByText(/^[1-9]/).waitFor(); // a frame has shown it
  for (const encoding of ['raw', 'draco', 'meshopt', 'quantised'] as const) {
    await setView({ encoding });
    await page.waitForFunction((isRaw) => (window.latticed.scene!.session.surface.grid?.step === 1) === isRaw, encoding === 'raw');
    await followsDefinition(page, OBJ);
  }
  await setView({ encoding: 'auto' });
  await page.waitForFunction(async () => {
    const { session } = window.latticed.scene!;
    session.setView({}); // decodes until the page knows how long that takes
    // Not every request brings an update: the next one is made after a second.
    await new Promise((resolve) => { session.on('update', resolve); setTimeout(resolve, 1000); });
    return /^(draco|meshopt): meshopt's 0.2 bytes more a point take [0-9.]+ ns at [0-9.e+]+ MB\/s, decoding saves [0-9.]+ ns$/
      .test(document.querySelector<HTMLElement>('[data-hud=bytes]')!.title);
  });
  await followsDefinition(page, OBJ);
  await setView({ encoding: 'quantised' });
  await undo(rest);
});

test('where nothing changes nothing is drawn', async () => {
  await page.waitForFunction(() => {
    const { isSmooth, frames: queue } = window.latticed.viewport as unknown as { isSmooth: boolean; frames: { isEmpty: boolean } };
    const { sync } = window.latticed.scene!.session as unknown as { sync: { queue: { sent: unknown[] } } };
    const isQuiet = sync.queue.sent.length === 0 && document.querySelector('[data-hud=updates]')!.textContent === '0';
    return isQuiet && isSmooth && queue.isEmpty;
  });
  const drawn = (): Promise<number> => page.evaluate(() => new Promise<number>((resolve) => {
    let [count, left] = [0, 90];
    const end = window.latticed.viewport.onDrawn(() => ++count);
    const next = (): void => void (--left > 0 ? requestAnimationFrame(next) : (end(), resolve(count)));
    next();
  }));
  await until(async () => (await drawn()) === 0); // an update, or an answer about folds, may be on its way
});

test('the page is dark or light as the system is, or as one says', async () => {
  const background = (): Promise<Vec3> => colourAt(page, [0, 0, 0]);
  const DARK = [0x14, 0x18, 0x1f];
  const LIGHT = [0xf3, 0xf5, 0xf9];
  const turnsTo = (theme: string): Promise<void> => page.locator(`html[data-theme=${theme}]`).waitFor();
  await page.evaluate(() => window.latticed.settings.set({ surface: false, cage: false }));
  const button = page.locator('[data-command=theme]');
  assert.deepEqual(await background(), LIGHT);

  await page.emulateMedia({ colorScheme: 'dark' });
  await turnsTo('dark');
  assert.deepEqual(await background(), DARK);
  await button.click(); // dark, whatever the system is
  await page.emulateMedia({ colorScheme: 'light' });
  await frames(page);
  await turnsTo('dark');
  await button.click(); // light
  await turnsTo('light');
  await page.emulateMedia({ colorScheme: 'dark' });
  await frames(page);
  assert.deepEqual(await background(), LIGHT);
  await button.click(); // as the system
  await turnsTo('dark');
  await page.evaluate(() => window.latticed.settings.set({ surface: true, cage: true }));
});

test('on a laptop all tools and the panel are there without scrolling sideways, dark and light', async () => {
  await page.setViewportSize({ width: 1366, height: 768 });
  await page.evaluate(() => window.latticed.settings.set({ gizmo: 'move', panel: true }));
  await select(CORNER);
  for (const theme of ['dark', 'light'] as const) {
    await page.evaluate((name) => window.latticed.settings.set({ theme: name }), theme);
    await press('Home');
    await frames(page);
    await shot(`viewer_laptop_${theme}`);
  }

  const hidden = await page.evaluate(() => ['.header', '.tools', '.side', '.footer'].flatMap((part) => {
    const element = document.querySelector(part)!;
    const down = part === '.side' ? 0 : element.scrollHeight - element.clientHeight; // the panel may scroll down
    return down > 0 || element.scrollWidth > element.clientWidth ? [part] : [];
  }));
  assert.deepEqual(hidden, []);
  assert.deepEqual(errors, []);
});

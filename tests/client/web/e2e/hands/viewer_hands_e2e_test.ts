// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Editing by hand in the viewer in Chromium: presses on points and handles, dialogs and their fields, keys, remarks.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { dot, length, sub, type Vec3 } from '@src/lattice/vec';
import { latticeToJson } from '@src/wire/lattice_json';
import { openPage } from '../support/browser';
import { browser, CORNER, errors, OBJ, openTorus, page, press, select, selected, shot, until, useStage } from '../support/stage';
import { camera, colourAt, controlPoint, dropFiles, frames, latticeIn, live, meshUploaded, onScreen, placeOf, pointComesTo } from '../support/viewer_page';

let rest: Vec3;

useStage({
  context: { viewport: { width: 640, height: 480 } },
  begin: async () => {
    await openTorus();
    rest = await controlPoint(page, CORNER);
  },
});

/** Goes back to the scene before, and waits until it is shown. */
async function goBack(): Promise<void> {
  await page.goBack();
  await page.waitForFunction(() => new URLSearchParams(location.search).get('scene') === window.latticed.scene!.session.sceneId);
  await live(page);
}

beforeEach(async () => {
  await page.evaluate(() => {
    window.latticed.settings.set({ gizmo: 'move' });
    window.latticed.commands.get('reset').run();
  });
  await pointComesTo(page, CORNER, rest);
  await select(CORNER);
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await frames(page);
});

async function drag([x, y]: readonly [number, number], dx: number, dy: number): Promise<void> {
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + dx, y + dy, { steps: 4 });
  await page.mouse.up();
}

test('a drag of a point below the handles moves it in the plane of the view, and an axis towards the eye is not drawn and takes no press', async () => {
  for (const gizmo of ['move', 'rotate', 'scale'] as const) {
    await page.evaluate((kind) => {
      const { settings, viewport, commands } = window.latticed;
      commands.get('reset').run();
      settings.set({ gizmo: kind });
      viewport.rig.lookFrom([1, 0.16, 0.2]); // the handle along X covers the point
    }, gizmo);
    await pointComesTo(page, CORNER, rest);
    await frames(page);
    const [x, y] = await onScreen(page, CORNER);

    await drag([x, y], 37, -23);

    const way = sub(await controlPoint(page, CORNER), rest);
    const [nowX, nowY] = await onScreen(page, CORNER);
    assert.ok(Math.hypot(nowX - x - 37, nowY - y + 23) < 2, `${gizmo}: ${[nowX - x, nowY - y]} is not 37, -23`);
    assert.ok(Math.abs(dot(way, (await camera(page)).basis[2])) < 1e-6, `${gizmo}: ${way}`);
  }

  const there = await controlPoint(page, CORNER);
  const seen = await camera(page);
  await page.evaluate(() => window.latticed.settings.set({ gizmo: 'move' }));
  await frames(page);
  const [x, y] = await onScreen(page, CORNER);
  const [tipX, tipY] = await placeOf(page, [there[0] + 0.3, there[1], there[2]]);
  const far = 14 / Math.hypot(tipX - x, tipY - y); // beyond the disc
  const isDrawn = async (axis: number): Promise<boolean> => {
    const point = there.map((c, i) => (i === axis ? c + (axis === 0 ? 0.3 : 0.15) * far : c)) as unknown as Vec3;
    const seenWith = async (gizmo: 'none' | 'move'): Promise<string> => {
      await page.evaluate((kind) => window.latticed.settings.set({ gizmo: kind }), gizmo);
      await frames(page);
      return String(await colourAt(page, point));
    };
    return (await seenWith('none')) !== (await seenWith('move'));
  };
  assert.deepEqual([await isDrawn(0), await isDrawn(2)], [false, true]);
  await drag([x + far * (tipX - x), y + far * (tipY - y)], 40, 30);
  assert.deepEqual(await controlPoint(page, CORNER), there);
  assert.ok(Math.abs(dot((await camera(page)).basis[2], seen.basis[2])) < 0.99, 'the drag turns the view');
});

test('Esc closes messages and leaves the tool, and Alt-A alone clears the selection, as in Blender', async () => {
  const tool = (): Promise<string> => page.evaluate(() => window.latticed.settings.value.tool);
  const toasts = page.locator('.toast');
  const shown = await page.evaluate(() => { // at once: the first one leaves by itself
    window.latticed.toasts.tell('A message.');
    window.latticed.toasts.fail('An error.');
    return document.querySelectorAll('.toast').length;
  });
  assert.equal(shown, 2);

  await press('b', 'Escape');
  assert.equal(await toasts.count(), 0);
  assert.equal(await tool(), 'select');
  await press('Escape');
  assert.deepEqual(await selected(), [CORNER]);
  await press('b', 'Alt+a');
  assert.deepEqual(await selected(), []);
  assert.equal(await tool(), 'box');
  await press('Escape');
});

test('arrows step through control points as they are seen, Shift adds, Ctrl goes into the depth', async () => {
  const after = async (...keys: string[]): Promise<number[]> => {
    await press(...keys);
    return selected();
  };
  await page.evaluate(() => window.latticed.viewport.rig.lookFrom([0, -1, 0])); // x to the right, z up
  await select(21); // (1, 1, 1) of 4 x 4 x 4

  assert.deepEqual(await after('ArrowRight'), [22]);
  assert.deepEqual(await after('ArrowUp'), [38]);
  assert.deepEqual(await after('Control+ArrowUp'), [42]);
  assert.deepEqual(await after('Control+ArrowDown', 'ArrowDown', 'ArrowLeft'), [21]);
  assert.deepEqual(await after('Shift+ArrowLeft', 'Shift+ArrowLeft'), [20, 21]); // the grid ends there

  await page.evaluate(() => window.latticed.viewport.rig.lookFrom([0, 1, 0]));
  await select(21);
  assert.deepEqual(await after('ArrowRight'), [20]);
  await page.locator('[data-command=soft]').focus();
  assert.deepEqual(await after('ArrowDown'), [20]); // the arrows of a toolbar are its own
});

test('undo and redo are grey while there is nothing of this window to undo or redo', async () => {
  const { page: other } = await openPage(browser, page.url());
  await live(other);
  const become = (undo: boolean, redo: boolean): Promise<unknown> => other.waitForFunction((wanted) =>
    String(['undo', 'redo'].map((id) => !document.querySelector<HTMLButtonElement>(`[data-command=${id}]`)!.disabled)) === wanted,
  String([undo, redo]));

  await become(false, false); // the steps of the first window are not its own
  await other.locator('[data-command=through]').focus();
  await other.keyboard.press('ArrowDown'); // passes over both
  await other.locator('[data-command=frame-selected]:focus').waitFor();
  await other.evaluate((index) => window.latticed.scene!.editor.selection.select([index]), CORNER);
  for (const key of ['g', 'z', '1', 'Enter']) await other.keyboard.press(key);
  await become(true, false);
  await other.locator('[data-command=undo]').click();
  await become(false, true);
  await other.locator('[data-command=redo]').click();
  await become(true, false);
  await other.keyboard.press('Control+z');
  await become(false, true);
  await other.close();
});

test('a field takes expressions, tells what is wrong with one, and gives the focus back', async () => {
  const x = page.getByLabel('Pivot X');
  const z = page.getByLabel('Pivot Z');
  const why = page.locator('.position .why');
  const focus = (): Promise<string | undefined> => page.evaluate(() => document.activeElement?.tagName);
  await page.evaluate(() => window.latticed.settings.set({ panel: true }));

  await x.fill('1/2 + pi');
  await x.press('Enter');
  const [typed] = await controlPoint(page, CORNER);
  assert.ok(Math.abs(typed - 0.5 - Math.PI) < 1e-12, `${typed}`);
  assert.equal(await focus(), 'CANVAS');
  await z.fill('+=0.25');
  await z.press('Enter');
  const there = await controlPoint(page, CORNER);
  assert.ok(Math.abs(there[2] - rest[2] - 0.25) < 1e-12, `${there}`);

  await z.fill('2*(1+');
  await z.press('Enter');
  await why.getByText('A number is missing.').waitFor();
  await shot('viewer_field');
  await z.fill('2*x');
  await z.press('Enter');
  await why.getByText('“x” is not understood here.').waitFor();
  assert.deepEqual(await controlPoint(page, CORNER), there);
  await z.press('Escape');
  assert.equal(await focus(), 'CANVAS');
  assert.equal(Number(await z.inputValue()), Number(there[2].toPrecision(4)));
  assert.equal((await why.allInnerTexts()).join(''), '');
  await press('Control+z', 'Control+z');
  await pointComesTo(page, CORNER, rest);
});

test('the page says that a scene is being made; the head-up line then starts anew, and tells on hover what it measures', async () => {
  const latency = page.locator('.hud span', { hasText: 'edit → pixel' });
  await page.evaluate(() => window.latticed.settings.set({ panel: false }));
  await press('g', 'z', '1', 'Enter');
  await latency.getByText(/^\d+$/).waitFor();
  const { x, y, width, height } = (await latency.boundingBox())!;
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.locator('.hud-tip').getByText(/^Median time from an edit .* The newest: server \d/).waitFor();
  await shot('viewer_hud');
  await page.mouse.move(5, 5);
  assert.ok(await page.locator('.hud-tip').isHidden());
  const held: (() => Promise<void>)[] = [];
  await page.route('**/CreateScene', async (route) => {
    const isTemporary = /preview-|rest-/.test(route.request().postDataBuffer()!.toString('latin1'));
    if (isTemporary) await route.continue();
    else held.push(() => route.continue());
  });
  const release = async (): Promise<void> => {
    await until(() => Promise.resolve(held.length > 0));
    await held.pop()!();
  };

  await dropFiles(page, [['torus.obj', OBJ]]);
  await meshUploaded(page);
  await page.locator('.fit h2').click(); // the focus is on nothing
  await press('Enter');
  await page.locator('.fit progress:indeterminate').waitFor();
  await page.keyboard.press('Escape');
  await release();
  await page.evaluate(() => window.latticed.opener.takeSample('beam'));
  await page.locator('.busy').getByText('Making the scene …').waitFor();
  await page.locator('.busy').evaluate((sign) => Promise.all(sign.getAnimations().map(({ finished }) => finished)));
  await shot('viewer_busy');
  await release();
  await page.unrouteAll();
  await page.locator('.busy').waitFor({ state: 'hidden' });

  await live(page);
  assert.equal(await latency.locator('b').innerText(), '–');
  await goBack();
});

test('a fold-over, a mesh outside the lattice and a tear are said in lines with buttons that select where', async () => {
  const remark = (kind: string) => page.locator(`.remark[data-remark=${kind}]`);
  const before = await page.evaluate(() => window.latticed.scene!.session.lattice.points.slice(0, 3));
  await page.waitForFunction(() => 'watch' in window.latticed && window.latticed['watch'] !== undefined);
  assert.equal(await page.locator('.remark').count(), 0);
  await select(0, 4, 16, 20);
  await press('g', 'x', '3', 'Enter');
  await remark('fold').waitFor();
  await shot('viewer_fold');
  await press('Alt+a');
  await remark('fold').getByRole('button', { name: 'Select' }).click();
  const where = await selected();
  assert.equal(where.length, 27);
  assert.ok([0, 4, 16, 20].some((index) => where.includes(index)), `${where}`);
  await press('Control+z');
  await remark('fold').waitFor({ state: 'detached' });
  await pointComesTo(page, 0, [before[0], before[1], before[2]]);

  // The right half of the torus is outside.
  const half = latticeIn([[-1.6, -1.6, -0.6], [1.6, 0, 0], [0, 3.2, 0], [0, 0, 1.2]], 3, 2);
  await dropFiles(page, [['lattice.json', latticeToJson(half)]]);
  await remark('outside').waitFor();
  await remark('outside').getByRole('button', { name: 'Select' }).click();
  const face = Array.from({ length: 9 }, (_, i) => 3 * i + 2);
  assert.deepEqual(await selected(), face);
  await select(0);
  await press('g', 'z', '-', '.', '1', 'Enter');
  await select(14);
  await press('g', 'z', '.', '3', 'Enter');
  await remark('tear').waitFor();
  assert.equal(await remark('outside').count(), 0);
  await shot('viewer_tear');
  await remark('tear').getByRole('button', { name: 'Select' }).click();
  assert.deepEqual(await selected(), [14]);

  await remark('tear').getByRole('button', { name: 'Close' }).click();
  await press('g', 'z', '.', '1', 'Enter');
  assert.equal(await remark('tear').count(), 0);
  await page.evaluate(() => window.latticed.commands.get('reset').run());
  await remark('outside').waitFor();
  await openTorus(); // a lattice of 4 x 4 x 4 again
});

test('a knot plane is shown before it is inserted: where the pointer hovers, and where a number is typed', async () => {
  const knot = page.getByLabel('Knot', { exact: true });
  await page.setViewportSize({ width: 960, height: 540 });
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await frames(page);
  const { min, max } = await page.evaluate(() => window.latticed.scene!.session.surface.bounds);
  const corner = await controlPoint(page, 0);
  const atU = (u: number): Vec3 => [corner[0] + (u / 2) * (rest[0] - corner[0]), corner[1], corner[2]]; // u is 0 to 2
  const beside: Vec3 = [min.x + 0.8 * (max.x - min.x), corner[1], 0]; // no line of the cage is near
  const before = await colourAt(page, beside);
  await page.evaluate(() => window.latticed.settings.set({ gizmo: 'none' }));
  await press('k');
  await frames(page);
  assert.deepEqual(await colourAt(page, beside), before);

  const [x, y] = await placeOf(page, atU(1.5));
  await page.mouse.move(x, y);
  const hovered = Number(await knot.inputValue());
  assert.ok(Math.abs(hovered - 1.5) < 0.05, `${hovered}`);
  await frames(page);
  await shot('viewer_knot');
  const share = (beside[0] - corner[0]) / (rest[0] - corner[0]);
  await knot.fill(`${2 * share}`);
  await frames(page);
  assert.notDeepEqual(await colourAt(page, beside, -2), before);
  await press('Escape');
  await frames(page);
  assert.deepEqual(await colourAt(page, beside), before);

  await press('k');
  await page.evaluate(() => window.latticed.settings.set({ panel: true }));
  await page.getByLabel('Pivot X').press('Enter');
  await page.evaluate(() => window.latticed.settings.set({ panel: false }));
  await frames(page);
  await page.getByLabel('Menus').getByText('View').click();
  await page.getByRole('menuitem', { name: 'Keys' }).click();
  await page.locator('dialog.help').press('Enter');
  await page.locator('dialog.help').waitFor({ state: 'detached' });
  const distanceOf = async (): Promise<number> => length(sub((await camera(page)).position, (await camera(page)).target));
  const seen = await camera(page);
  const away = await distanceOf();
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 30, y, { steps: 3 });
  await page.mouse.up();
  assert.notDeepEqual((await camera(page)).basis, seen.basis, 'a drag turns the view');
  await page.mouse.wheel(0, 100);
  await until(async () => (await distanceOf()) > 1.01 * away);
  assert.equal(await page.locator('dialog.knot').count(), 1);
  assert.equal(await page.evaluate(() => window.latticed.scene!.session.lattice.count), 64, 'none of this inserts a knot');
  await page.evaluate(({ position, target }) => {
    const { rig } = window.latticed.viewport;
    rig.camera.position.set(...position);
    rig.target.set(...target);
    rig.controls.update();
  }, seen);

  await page.mouse.move(x + 1, y);
  await page.mouse.click(x, y);
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 80);
  const knots = await page.evaluate(() => [...window.latticed.scene!.session.lattice.knots[0]]);
  assert.ok(knots.some((value) => Math.abs(value - hovered) < 0.021), `${knots}`);
  await page.locator('dialog').waitFor({ state: 'detached' });
  await press('Control+z');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 64);
  await page.setViewportSize({ width: 640, height: 480 });
});

test('the dialog shows the mesh in the lattice, and picture and count follow the typing', async () => {
  /** How many pixels the mesh and the cage have. */
  const seen = (): Promise<readonly [mesh: number, cage: number]> => page.locator('.fit-preview').evaluate((element) => {
    const canvas = element as HTMLCanvasElement;
    const { data } = canvas.getContext('2d')!.getImageData(0, 0, canvas.width, canvas.height);
    let [mesh, cage] = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] === 255 && data[i] > 80 && data[i] === data[i + 1]) ++mesh;
      else if (data[i + 3] > 0) ++cage;
    }
    return [mesh, cage];
  });
  await dropFiles(page, [['torus.obj', OBJ]]);
  await meshUploaded(page);
  await until(async () => (await seen())[0] > 2000);
  const [mesh, cage] = await seen();
  await page.getByLabel('Points along u').fill('2*4');
  await page.getByText('128 control points').waitFor();
  const create = page.getByRole('button', { name: 'Create scene' });
  for (const [label, wrong, right] of [['Points along u', '100', '8'], ['Padding', '-1', '5'], ['Crease angle', '181', '30']] as const) {
    await page.getByLabel(label).fill(wrong);
    await page.getByLabel('Points along w').focus();
    await page.locator('.fit .why').getByText(/number from \d/).waitFor();
    assert.ok(await create.isDisabled(), label);
    await page.getByLabel(label).fill(right);
    assert.ok(await create.isEnabled(), label);
  }
  assert.ok((await seen())[1] > cage * 1.1, `${await seen()} after ${cage}`);
  await shot('viewer_fit_preview');
  await page.getByLabel('Padding').fill('50');
  assert.ok((await seen())[0] < mesh / 2, `${await seen()} after ${mesh}`); // the lattice fills the picture
  await press('Escape');
  await page.locator('dialog').waitFor({ state: 'detached' });
});

test('a message leaves by itself, but not below the pointer', async () => {
  await page.mouse.move(5, 5);
  await page.evaluate(() => {
    const [setTimer, clearTimer] = [window.setTimeout.bind(window), window.clearTimeout.bind(window)];
    const due = new Map<number, () => void>();
    let last = -1;
    Object.assign(window, {
      due,
      setTimeout: (act: () => void, ms: number) => (ms === 5000 ? (due.set(--last, act), last) : setTimer(act, ms)),
      clearTimeout: (timer: number) => void (due.delete(timer) || clearTimer(timer)),
    });
    window.latticed.toasts.tell('A message.');
  });
  const dueIs = (count: number): Promise<unknown> =>
    page.waitForFunction((n) => (window as unknown as { due: Map<number, unknown> }).due.size === n, count);
  await dueIs(1);
  await page.locator('.toast').hover();
  await dueIs(0);
  await page.mouse.move(5, 5);
  await dueIs(1);
  await page.evaluate(() => (window as unknown as { due: Map<number, () => void> }).due.forEach((act) => act()));
  assert.equal(await page.locator('.toast').count(), 0);
  assert.deepEqual(errors, []);
});

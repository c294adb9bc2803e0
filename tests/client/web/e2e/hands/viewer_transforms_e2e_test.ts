// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Transforms in the viewer in Chromium, by Blender's keys, the wheel and the handles.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { add, distance, scale, sub, type Vec3 } from '@src/lattice/vec';
import { followsDefinition } from '../support/definition';
import { CORNER, errors, OBJ, openTorus, page, pointAtServer, press, select, selected, server, until, useStage } from '../support/stage';
import { colourAt, controlPoint, frames, onScreen, placeOf, pointComesTo, upperHandle } from '../support/viewer_page';

const BESIDE = 62;

let rest: Vec3;

function comesTo(index: number, place: Vec3): Promise<void> {
  return pointComesTo(page, index, place);
}

function assertNear(got: Vec3, wanted: Vec3, most = 1e-9): void {
  assert.ok(distance(got, wanted) < most, `${got} is not ${wanted}`);
}

/** Whether a number is a multiple of a step other than 0. */
function isStepped(x: number, step: number): boolean {
  return Math.abs(x) > step / 2 && Math.abs(x / step - Math.round(x / step)) < 1e-6;
}

useStage({
  context: { viewport: { width: 640, height: 480 } },
  begin: async () => {
    await openTorus();
    rest = await controlPoint(page, CORNER);
  },
});

beforeEach(async () => {
  await page.evaluate(() => {
    window.latticed.settings.set({
      toggling: false, gizmo: 'move', orientation: 'world', pivot: 'median', mirror: [false, false, false],
      soft: { enabled: false, radius: 0.5, falloff: 'smooth' },
    });
    window.latticed.commands.get('reset').run();
  });
  await comesTo(CORNER, rest);
  await select(CORNER);
  await page.evaluate(() => window.latticed.scene!.frameAll());
  await frames(page); // draws the handles
});

test('G 1 Tab 2 Tab - . 5 Enter moves by three numbers', async () => {
  await press('g', '1', 'Tab', '2', 'Tab', '-', '.', '5', 'Enter');

  const there = await controlPoint(page, CORNER);
  assert.ok(distance(there, [rest[0] + 1, rest[1] + 2, rest[2] - 0.5]) < 1e-12, `${there} from ${rest}`);
  assert.equal(await page.evaluate(() => document.activeElement?.tagName), 'BODY'); // Tab did not move the focus
});

test('the point below the pointer is not marked while a transform runs', async () => {
  const hovered = (): Promise<number | undefined> =>
    page.evaluate(() => (window.latticed.scene as unknown as { cage: { hovered: number | undefined } }).cage.hovered);
  const [x, y] = await onScreen(page, 3);
  await page.mouse.move(x, y);
  assert.equal(await hovered(), 3);
  await press('g');
  await page.mouse.move(x + 30, y);
  assert.equal(await hovered(), undefined);
  await press('Escape');
  await page.mouse.move(x, y);
  assert.equal(await hovered(), 3);
});

test('the wheel turns the reach of soft selection while a transform runs, and does not zoom', async () => {
  const distanceOfCamera = (): Promise<number> => page.evaluate(() => window.latticed.viewport.rig.camera.position.length());
  const [x, y] = await onScreen(page, CORNER);
  const far = await distanceOfCamera();
  await press('o');
  await page.mouse.move(x, y);
  await press('g', 'z', '1');
  const still = await controlPoint(page, BESIDE); // beyond the reach at first

  for (let i = 0; i < 9; ++i) await page.mouse.wheel(0, 100);
  await page.waitForFunction(() => Math.abs(window.latticed.settings.value.soft.radius - 0.5 * 1.1 ** 9) < 1e-9);
  const lifted = await controlPoint(page, BESIDE);
  assert.ok(lifted[2] > still[2] && lifted[2] < still[2] + 1, `${lifted} from ${still}`);
  assert.match(await page.locator('.hint').innerText(), /^Move\s+1/);
  await press('Escape');

  assert.deepEqual(await controlPoint(page, BESIDE), still);
  assert.equal(await distanceOfCamera(), far);
  await page.mouse.wheel(0, 100);
  await page.waitForFunction((was) => window.latticed.viewport.rig.camera.position.length() > was, far);
});

test('a handle moves along its axis; Escape and a right click let go of it without an effect', async () => {
  const tip = await upperHandle(page, rest);
  const hold = async (): Promise<void> => {
    await frames(page);
    await page.mouse.move(...tip);
    await page.mouse.down();
    await page.mouse.move(tip[0], tip[1] - 40, { steps: 4 });
    const [, , z] = await controlPoint(page, CORNER);
    assert.ok(z > rest[2] + 0.05, `${z} from ${rest[2]}`);
    const said = /^Move\s+0\s+0\s+(\S+)\s+\(\S+\)\s+along Z \(world\)$/.exec(await page.locator('.hint.running').innerText());
    assert.ok(Math.abs(Number(said?.[1]) - (z - rest[2])) < 1e-3, `${said?.[0]} is not ${z - rest[2]}`);
  };
  const release = async (): Promise<void> => {
    await page.mouse.move(tip[0], tip[1] - 60, { steps: 2 });
    await page.mouse.up();
  };
  const clickRight = async (): Promise<void> => {
    await page.mouse.down({ button: 'right' });
    await page.mouse.up({ button: 'right' });
  };
  for (const letGo of [() => press('Escape'), clickRight]) {
    await hold();
    await letGo();
    await release();
    assert.deepEqual(await controlPoint(page, CORNER), rest);
    assert.deepEqual(await selected(), [CORNER]);
  }

  await hold();
  await release();
  const [x, y, z] = await controlPoint(page, CORNER);
  assert.ok(Math.hypot(x - rest[0], y - rest[1]) < 1e-9 && z > rest[2] + 0.05, `${[x, y, z]} from ${rest}`);
  assert.equal(await page.locator('.hint.running').count(), 0);
});

test('while the server stands still the cage and the handles follow the pointer, and then the server has what was done', async () => {
  const handles = (): Promise<Vec3> => page.evaluate(() => {
    const { gizmo } = window.latticed.scene as unknown as { gizmo: { standIn: { position: { toArray(): number[] } } } };
    return gizmo.standIn.position.toArray() as unknown as Vec3;
  });
  const disc = await colourAt(page, rest);
  const tip = await upperHandle(page, rest);

  server.halt();
  await page.mouse.move(...tip);
  await page.mouse.down();
  await page.mouse.move(tip[0], tip[1] - 40, { steps: 4 });
  const lifted = await controlPoint(page, CORNER);
  assert.ok(lifted[2] > rest[2] + 0.05, `${lifted} from ${rest}`);
  assertNear(await handles(), lifted);
  await page.mouse.up();
  await frames(page);
  assert.ok(distance(await colourAt(page, rest), disc) > 30, 'the disc is still where it was');

  server.goOn();
  await until(async () => String(await pointAtServer(CORNER)) === String(lifted));
  await followsDefinition(page, OBJ);
});

test('an undo while a handle is held, or a transform runs, ends that and takes it back', async () => {
  const tip = await upperHandle(page, rest);
  const isHeld = (): Promise<boolean> =>
    page.evaluate(() => (window.latticed.scene as unknown as { gizmo: { dragging: boolean } }).gizmo.dragging);
  await page.mouse.move(...tip);
  await page.mouse.down();
  await page.mouse.move(tip[0], tip[1] - 40, { steps: 4 });
  assert.ok(await isHeld());
  await press('Control+z');
  assert.ok(!(await isHeld()));
  await comesTo(CORNER, rest);
  await page.mouse.move(tip[0], tip[1] - 60, { steps: 2 });
  await page.mouse.up();
  assert.deepEqual(await selected(), [CORNER]);

  await press('g', 'z', '1');
  await page.evaluate(() => window.latticed.commands.get('undo').run()); // as its button does
  assert.equal(await page.locator('.hint.running').count(), 0);
  await comesTo(CORNER, rest);
  await press('2', 'Enter');
  assert.deepEqual(await controlPoint(page, CORNER), rest);
});

test('Ctrl-Shift-Z and Ctrl-Y do again what Ctrl-Z took back, until something else is done', async () => {
  const moved = add(rest, [0, 0, 1]);
  await press('g', 'z', '1', 'Enter');
  for (const redo of ['Control+Shift+Z', 'Control+y']) {
    await press('Control+z');
    await comesTo(CORNER, rest);
    await press(redo);
    await comesTo(CORNER, moved);
  }

  await press('Control+z');
  await comesTo(CORNER, rest);
  await press('g', 'x', '2', 'Enter', 'Control+y');
  await page.locator('.toast:not(.toast-error)').getByText('There is nothing to redo.').waitFor();
  assertNear(await controlPoint(page, CORNER), add(rest, [2, 0, 0]));
  await press('Control+z');
  await comesTo(CORNER, rest);
});

test('a dragged point snaps with Ctrl, and with Shift goes a tenth of the way', async () => {
  await page.evaluate(() => window.latticed.settings.set({ gizmo: 'none' }));
  const [x, y] = await onScreen(page, CORNER);
  const step = await page.evaluate(([px, py, pz]) => {
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] as const;
    return window.latticed.viewport.transformView([px, py, pz], axes, axes).snapStep;
  }, rest);
  const dragWith = async (key: string): Promise<Vec3> => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.keyboard.down(key);
    await page.mouse.move(x - 120, y + 70, { steps: 4 });
    const way = sub(await controlPoint(page, CORNER), rest);
    await page.keyboard.up(key);
    await press('Escape');
    await page.mouse.up();
    return way;
  };

  const free = await dragWith('a'); // a key without a meaning
  const snapped = await dragWith('Control');
  const fine = await dragWith('Shift');

  assert.ok(!free.every((way) => isStepped(way, step)), `${free}`);
  snapped.forEach((way, axis) => {
    assert.ok(Math.abs(way - Math.round(free[axis] / step) * step) < 1e-9, `${snapped} is not ${free} in steps of ${step}`);
  });
  assertNear(fine, scale(free, 0.1), 1e-6);
  assertNear(await controlPoint(page, CORNER), rest);
});

test('. takes the active point or each as the pivot, S 2 scales about it, and Alt-U does the same on the other side', async () => {
  const beside = await controlPoint(page, BESIDE);
  const across = await controlPoint(page, 60); // the other end of the row along u, 60 to 63
  await select(BESIDE, CORNER); // the last one is active

  await press('s', '2', 'Enter');
  const middle = scale(add(rest, beside), 0.5);
  assertNear(await controlPoint(page, CORNER), add(middle, scale(sub(rest, middle), 2)));
  assertNear(await controlPoint(page, BESIDE), add(middle, scale(sub(beside, middle), 2)));
  await press('Control+z');
  await comesTo(CORNER, rest);

  await press('.', 'r', 'z', '9', '0', 'Enter');
  assert.equal(await page.evaluate(() => window.latticed.settings.value.pivot), 'active');
  assertNear(await controlPoint(page, CORNER), rest);
  assertNear(await controlPoint(page, BESIDE), [rest[0], rest[1] - (rest[0] - beside[0]), rest[2]]);
  await press('Control+z');
  await comesTo(BESIDE, beside);

  await press('.', 's', '2', 'Enter'); // a point scaled about itself stays
  assert.equal(await page.evaluate(() => window.latticed.settings.value.pivot), 'each');
  assertNear(await controlPoint(page, BESIDE), beside);

  await select(CORNER);
  await press('Alt+u', 'g', '1', 'Tab', '.', '5', 'Enter');
  assertNear(await controlPoint(page, CORNER), add(rest, [1, 0.5, 0]));
  assertNear(await controlPoint(page, 60), add(across, [-1, 0.5, 0]));
});

test('the panel mirrors over v, w, and both', async () => {
  const images = [[51, [1, -0.5, 0.25]], [15, [1, 0.5, -0.25]], [3, [1, -0.5, -0.25]]] as const; // images of point 63
  const at = await Promise.all(images.map(([index]) => controlPoint(page, index)));
  await press('n');
  for (const axis of ['v', 'w']) await page.getByTitle(`Mirror over ${axis}`).click();
  await press('n', 'g', '1', 'Tab', '.', '5', 'Tab', '.', '2', '5', 'Enter');

  assertNear(await controlPoint(page, CORNER), add(rest, [1, 0.5, 0.25]));
  for (const [i, [index, way]] of images.entries()) assertNear(await controlPoint(page, index), add(at[i], way));
  const moved = await page.evaluate(([i, x]) => window.latticed.scene!.session.lattice.points[3 * i] !== x, [60, -rest[0]] as const);
  assert.ok(!moved, 'over u as well');
});

test('the axes of the view are those of the camera', async () => {
  await press(',', ',');
  assert.equal(await page.evaluate(() => window.latticed.settings.value.orientation), 'view');

  await press('g', 'x', '1', 'Enter');

  const [right] = await page.evaluate(() => window.latticed.viewport.rig.basis());
  assertNear(await controlPoint(page, CORNER), add(rest, right));
});

test('handles turn and scale about the pivot, with Ctrl in steps', async () => {
  const beside = await controlPoint(page, BESIDE);
  const pivot = scale(add(rest, beside), 0.5);
  /** Drags a handle with Ctrl. It is at `heights` heights of the view from the pivot, along a world direction. */
  const dragHandle = async (gizmo: 'rotate' | 'scale', along: Vec3, heights: number, way: readonly [number, number]): Promise<void> => {
    await page.evaluate((kind) => window.latticed.settings.set({ gizmo: kind }), gizmo);
    await frames(page);
    const { height } = (await page.locator('canvas').boundingBox())!;
    const [x, y] = await placeOf(page, pivot);
    const [ux, uy] = await placeOf(page, add(pivot, scale(along, 0.1)));
    const unit = await page.evaluate(([px, py, pz]) => window.latticed.viewport.disc([px, py, pz], 0.1)!.radius, pivot);
    const from = [x + ((ux - x) * heights * height) / unit, y + ((uy - y) * heights * height) / unit] as const;
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.keyboard.down('Control');
    await page.mouse.move(from[0] + way[0], from[1] + way[1], { steps: 3 });
    await page.mouse.up();
    await page.keyboard.up('Control');
  };
  await select(BESIDE, CORNER);
  const view = await page.evaluate(() => window.latticed.viewport.rig.basis()[2]);

  // The point of the ring around Z that is nearest to the camera.
  await dragHandle('rotate', scale([view[0], view[1], 0], 1 / Math.hypot(view[0], view[1])), 0.107, [37, 0]);
  const [dx, dy, dz] = sub(await controlPoint(page, CORNER), pivot);
  const degrees = (Math.atan2(dy, dx) * 180) / Math.PI;
  assert.ok(isStepped(degrees, 5) && Math.abs(dz) < 1e-9, `${[dx, dy, dz]}`);
  assert.ok(Math.abs(Math.hypot(dx, dy) - distance(rest, pivot)) < 1e-9);
  assertNear(await controlPoint(page, BESIDE), sub(pivot, [dx, dy, dz]));
  await press('Control+z');
  await comesTo(CORNER, rest);

  await dragHandle('scale', [1, 0, 0], 0.06, [37, -20]); // at 0.08 the handle lies over the point
  const factor = ((await controlPoint(page, CORNER))[0] - pivot[0]) / (rest[0] - pivot[0]);
  assert.ok(isStepped(factor, 0.1) && Math.abs(factor - 1) > 0.05, `${factor}`);
  assertNear(await controlPoint(page, CORNER), [pivot[0] + factor * (rest[0] - pivot[0]), rest[1], rest[2]]);
  assertNear(await controlPoint(page, BESIDE), [pivot[0] + factor * (beside[0] - pivot[0]), beside[1], beside[2]]);
  assert.deepEqual(errors, []);
});

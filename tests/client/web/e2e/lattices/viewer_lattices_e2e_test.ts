// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of two lattices in the viewer in Chromium: the panel chooses whose cage is shown and edited.
// Environment: LATTICED, LATTICECTL, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { latticeAtRest } from '@src/lattice/identity';
import { scale } from '@src/lattice/vec';
import { latticeToJson } from '@src/wire/lattice_json';
import { toLattice } from '@src/wire/lattice_message';
import { openPage } from '../support/browser';
import { browser, CORNER, direct, errors, openTorus, page, press, select, server, shot, useStage } from '../support/stage';
import { live, segmentsCome } from '../support/viewer_page';

useStage({ context: { viewport: { width: 920, height: 560 } }, begin: openTorus });

/** Makes a scene of the page's mesh with a second lattice, of 3 x 3 x 3 control points, turned about w by an angle, and opens it. */
async function openTwo(sceneId: string, turn: number): Promise<void> {
  await page.evaluate(async ({ sceneId, turn }) => {
    const { session } = window.latticed.scene!;
    const { scenes } = session.server;
    const [{ lattice }, { mesh }] = await Promise.all([
      scenes.getLattice({ scene: session.sceneId }), scenes.getScene({ scene: session.sceneId })]);
    const { frame } = lattice!;
    const [cosine, sine] = [Math.cos(turn), Math.sin(turn)];
    const { u, v, w, origin } = frame!;
    const grown = turn === 0 ? 1 : 2; // the mesh is in it too when it is turned
    const mixed = (a: number, b: number): { x: number; y: number; z: number } =>
      ({ x: grown * (a * u!.x + b * v!.x), y: grown * (a * u!.y + b * v!.y), z: grown * (a * u!.z + b * v!.z) });
    const [newU, newV, newW] = [mixed(cosine, sine), mixed(-sine, cosine), { x: grown * w!.x, y: grown * w!.y, z: grown * w!.z }];
    const begin = (axis: 'x' | 'y' | 'z'): number =>
      origin![axis] + (u![axis] + v![axis] + w![axis] - newU[axis] - newV[axis] - newW[axis]) / 2;
    const turned = { origin: { x: begin('x'), y: begin('y'), z: begin('z') }, u: newU, v: newV, w: newW };
    const second = { frame: turned, size: { u: 3, v: 3, w: 3 }, degree: { u: 2, v: 2, w: 2 } };
    await scenes.createScene({ sceneId, mesh, lattices: [
      { source: { case: 'lattice', value: lattice! } }, { source: { case: 'lattice', value: second } }] });
  }, { sceneId, turn });
  const address = new URL(page.url());
  address.searchParams.set('scene', sceneId);
  await page.goto(address.href);
  await live(page);
}

const count = (): Promise<number> => page.evaluate(() => window.latticed.scene!.session.lattice.count);
const top = (): Promise<number> => page.evaluate(() => window.latticed.scene!.session.surface.bounds.max.z);

test('each lattice has its cage, its edits and its undo steps, and the moves of both add up', async () => {
  await openTwo('two-lattices', 0);
  const choice = page.getByRole('combobox', { name: 'Lattice', exact: true });
  assert.equal(await count(), 64);
  const rest = await top();
  await select(...Array.from({ length: 16 }, (_, i) => 48 + i)); // the highest layer
  await press('g', 'z', '1', 'Enter');
  await page.waitForFunction(() => window.latticed.scene!.session.canUndo);

  await choice.selectOption('2 of 2');

  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);
  assert.equal(await page.evaluate(() => window.latticed.scene!.session.canUndo), false);
  await select(...Array.from({ length: 9 }, (_, i) => 18 + i));
  await press('g', 'z', '1', 'Enter');
  await page.waitForFunction((least) => window.latticed.scene!.session.surface.bounds.max.z > least, rest + 1.2);
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await page.waitForFunction((most) => window.latticed.scene!.session.surface.bounds.max.z < most, rest + 1.1);
  await choice.selectOption('1 of 2');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 64);
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await page.waitForFunction((most) => window.latticed.scene!.session.surface.bounds.max.z < most, rest + 0.1);
});

/** Chooses a file in the dialog of parents, by its bytes. */
async function chooseParent(name: string, text: string): Promise<void> {
  const [chooser] = await Promise.all([
    page.waitForEvent('filechooser'), page.locator('dialog.carry').getByRole('button', { name: 'Choose…' }).click()]);
  await chooser.setFiles({ name, mimeType: 'application/json', buffer: Buffer.from(text) });
  await page.locator('dialog.carry').getByText(name, { exact: true }).waitFor();
}

const pointsOf = async (scene: string): Promise<number[]> => (await direct.scenes.getLattice({ scene })).lattice!.controlPoints;

test('a parent of a file carries the selected control points as latticectl does, and undo puts them back', async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'latticed-parent-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const { mesh } = await direct.scenes.getScene({ scene: 'two-lattices' });
  const { lattice } = await direct.scenes.getLattice({ scene: 'two-lattices' });
  await direct.scenes.createScene({ sceneId: 'twin', mesh, lattices: [{ source: { case: 'lattice', value: lattice! } }] });
  const { frame } = toLattice(lattice!);
  const parent = latticeAtRest({ ...frame, w: scale(frame.w, 0.8) }, [3, 3, 4], [2, 1, 3]);
  const atRest = latticeToJson(parent);
  parent.points.forEach((x, i) => (parent.points[i] = x + 0.3 * Math.cos(i)));
  writeFileSync(join(folder, 'parent.json'), latticeToJson(parent));
  execFileSync(process.env.LATTICECTL!, ['edit', 'carry', 'twin', '--lattice', 'parent.json', '--server', server.grpcAddress,
    ...['1,1,1', '0,0,0', '2,3,0', '3,3,3'].flatMap((place) => ['--point', place])], { cwd: folder, stdio: 'ignore' });
  const before = await pointsOf('two-lattices');
  const expected = await pointsOf('twin');
  assert.equal(expected.filter((x, i) => x !== before[i]).length, 9, 'three are inside the parent');
  await select(21, 0, 14, CORNER);

  await page.getByRole('button', { name: 'Edit', exact: true }).click();
  await page.getByRole('menuitem', { name: 'Carry by a parent lattice…' }).click();
  const dialog = page.locator('dialog.carry');
  const carry = dialog.getByRole('button', { name: 'Carry', exact: true });
  await dialog.getByText('All 4 selected points go along.').waitFor();
  await chooseParent('notes.json', '{"frame": 1}');
  await dialog.getByText('The file is not the JSON of a lattice').waitFor();
  assert.ok(await carry.isDisabled());
  await chooseParent('rest.json', atRest);
  await dialog.getByText('The parent is at rest: it moves nothing.').waitFor();
  assert.ok(await carry.isDisabled());
  await chooseParent('endless.json', latticeToJson(parent).replace('{', '{ "outside": { "mode": "OUTSIDE_MODE_LINEAR" },'));
  await carry.click();
  await dialog.getByText('outside.widths').waitFor();
  await chooseParent('parent.json', latticeToJson(parent));
  await dialog.getByText('3 of 4 selected points go along.').waitFor();
  await shot('viewer_carry');
  await carry.click();

  await dialog.waitFor({ state: 'detached' });
  assert.deepEqual(await pointsOf('two-lattices'), expected);
  await page.waitForFunction((x) => window.latticed.scene!.session.lattice.points[0] === x, expected[0]);
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await page.waitForFunction((x) => window.latticed.scene!.session.lattice.points[0] === x, before[0]);
  assert.deepEqual(await pointsOf('two-lattices'), before);
});

test('another lattice of the scene may be the parent, and without a selection all control points go along', async () => {
  const choice = page.getByRole('combobox', { name: 'Lattice', exact: true });
  const before = await pointsOf('two-lattices');
  await choice.selectOption('2 of 2');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);
  await page.evaluate(() => window.latticed.scene!.carryPoints());
  const dialog = page.locator('dialog.carry');
  await dialog.getByRole('combobox', { name: 'Parent' }).selectOption('Lattice 1 of 2');
  await dialog.getByText('The parent is at rest: it moves nothing.').waitFor();
  await choice.selectOption('1 of 2');
  await dialog.waitFor({ state: 'detached' }); // it was about another lattice
  await choice.selectOption('2 of 2');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);
  await select(...Array.from({ length: 27 }, (_, i) => i));
  await press('g', 'z', '1', 'Enter');
  await page.waitForFunction(() => window.latticed.scene!.session.canUndo);
  await choice.selectOption('1 of 2');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 64);
  await page.evaluate(() => window.latticed.scene!.editor.selection.none());

  await page.evaluate(() => window.latticed.scene!.carryPoints());
  await dialog.getByText('All 64 control points go along.').waitFor();
  await dialog.getByRole('combobox', { name: 'Parent' }).selectOption('Lattice 2 of 2');
  assert.ok(await dialog.getByRole('button', { name: 'Carry', exact: true }).isEnabled());
  await shot('viewer_carry_by_lattice');
  await press('Enter');

  await dialog.waitFor({ state: 'detached' });
  const after = await pointsOf('two-lattices');
  after.forEach((x, i) => assert.ok(Math.abs(x - before[i]! - (i % 3 === 2 ? 1 : 0)) < 1e-12, `coordinate ${i}: ${x}`));
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await page.waitForFunction((z) => window.latticed.scene!.session.lattice.points[2] === z, before[2]);
  await choice.selectOption('2 of 2');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await page.waitForFunction(() => !window.latticed.scene!.session.canUndo);
  await choice.selectOption('1 of 2');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 64);
});

test('one is added in the middle of the frame, where its handles are dragged to, and undone', async () => {
  await page.evaluate(() => window.latticed.scene!.addLattice());
  await page.locator('dialog.add-lattice').waitFor();
  const handle = page.getByRole('slider', { name: 'Face at the end of w' });
  assert.equal(await handle.getAttribute('aria-valuenow'), '-0.250');
  await handle.focus();
  await press('ArrowUp', 'ArrowUp', 'ArrowUp');
  assert.equal(await handle.getAttribute('aria-valuenow'), '-0.100');
  await shot('viewer_add_lattice');
  await page.getByRole('button', { name: 'Add', exact: true }).click();

  await page.waitForFunction(() => window.latticed.scene!.session.latticeCount === 3);
  await page.waitForFunction(() => window.latticed.scene!.session.latticeIndex === 2);
  const { w, first } = await page.evaluate(async () => {
    const { session } = window.latticed.scene!;
    const { lattice } = await session.server.scenes.getLattice({ scene: session.sceneId });
    return { w: session.lattice.frame.w[2], first: lattice!.frame!.w!.z };
  });
  assert.ok(Math.abs(w / first - 0.65) < 1e-12);
  assert.equal(await page.evaluate(() => window.latticed.scene!.session.lattice.outside?.mode), 'falloff');
  const rest = await top();
  await select(...Array.from({ length: 64 }, (_, i) => i));
  await press('g', 'z', '1', 'Enter');
  await page.waitForFunction((least) => window.latticed.scene!.session.surface.bounds.max.z > least, rest + 0.5);
  await page.evaluate(() => window.latticed.scene!.session.undo());
  await page.waitForFunction((most) => window.latticed.scene!.session.surface.bounds.max.z < most, rest + 0.1);
  await page.getByRole('combobox', { name: 'Lattice', exact: true }).selectOption('1 of 3');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.outside === undefined);
});

test('what others have selected is marked in the cage of their lattice alone', async () => {
  const { page: other, errors } = await openPage(browser, page.url());
  await live(other);
  await other.evaluate(() => window.latticed.scene!.session.chooseLattice(1));
  await other.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);

  await other.evaluate(() => window.latticed.scene!.editor.selection.select([3]));

  const marked = (): number => window.latticed.scene!['cage']['others'].length;
  await page.waitForFunction(() => [...window.latticed.scene!.session.others.values()].some(({ selected }) => selected[0] === 3));
  assert.equal(await page.evaluate(marked), 0);
  const choice = page.getByRole('combobox', { name: 'Lattice', exact: true });
  await choice.selectOption('2 of 3');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);
  assert.equal(await page.evaluate(marked), 1);
  await other.evaluate(() => window.latticed.scene!.editor.selection.select([5, 6]));
  await choice.selectOption('1 of 3');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 64);
  assert.equal(await page.evaluate(marked), 0);
  assert.deepEqual(errors, []);
  await other.close();
});

test('one is removed by its button, and undo gives it back with its points', async () => {
  const choice = page.getByRole('combobox', { name: 'Lattice', exact: true });
  await choice.selectOption('2 of 3');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);
  await select(3);
  await press('g', 'x', '1', 'Enter');
  await page.waitForFunction(() => window.latticed.scene!.session.canUndo);
  const points = (): Promise<number[]> => page.evaluate(() => Array.from(window.latticed.scene!.session.lattice.points));
  const before = await points();
  const numbers = (): Promise<readonly number[]> => page.evaluate(() => window.latticed.scene!.session.latticeNumbers);

  await page.getByRole('button', { name: 'Remove', exact: true }).click();

  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 64);
  assert.deepEqual(await numbers(), [0, 2]);
  assert.deepEqual(await choice.locator('option').allTextContents(), ['1 of 2', '2 of 2']);
  await shot('viewer_remove_lattice');
  await page.locator('canvas').first().focus();
  await press('Control+z');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);
  assert.deepEqual(await numbers(), [0, 1, 2]);
  assert.deepEqual(await points(), before);
  await press('Control+z');  // the move
  await page.waitForFunction((x) => window.latticed.scene!.session.lattice.points[9] !== x, before[9]);
});

test('a box that the server refuses is told in the dialog, which stays until one is added', async () => {
  await page.evaluate(() => window.latticed.scene!.addLattice());
  const dialog = page.locator('dialog.add-lattice');
  const add = dialog.getByRole('button', { name: 'Add', exact: true });
  await dialog.getByRole('radio', { name: 'Stays' }).click();  // the surface would tear where the box ends
  await add.click();

  await dialog.getByText('ends inside the mesh').waitFor();
  assert.ok(await add.isEnabled());
  assert.equal(await page.evaluate(() => window.latticed.scene!.session.latticeCount), 3);
  await dialog.getByRole('radio', { name: 'Falloff' }).click();
  const width = dialog.getByRole('spinbutton', { name: 'Width of all sides' });
  assert.equal(await width.inputValue(), '0.5');
  await width.fill('2000');
  assert.ok(await add.isDisabled());
  await width.fill('0.25');
  await width.press('Tab');
  await dialog.getByText('Each side').click();
  const side = dialog.getByRole('spinbutton', { name: 'Width at the end of v' });
  await side.fill('0.75');
  await side.press('Tab');
  await dialog.getByText('Smooth at the faces').click();
  await add.click();
  await dialog.waitFor({ state: 'detached' });
  assert.equal(await page.evaluate(() => window.latticed.scene!.session.latticeCount), 4);
  const outside = await page.evaluate(() => {
    const { mode, smooth, widths } = window.latticed.scene!.session.lattice.outside!;
    return { mode, smooth, widths: [...widths] };
  });
  assert.deepEqual(outside, { mode: 'falloff', smooth: false, widths: [0.25, 0.25, 0.25, 0.75, 0.25, 0.25] });
});

test('an added lattice may go on along straight lines, as far as the mesh reaches', async () => {
  await page.evaluate(() => window.latticed.scene!.addLattice());
  const dialog = page.locator('dialog.add-lattice');
  await dialog.getByRole('radio', { name: 'Linear' }).click();
  assert.equal(await dialog.getByRole('spinbutton', { name: 'Width of all sides' }).isHidden(), true);

  await dialog.getByRole('button', { name: 'Add', exact: true }).click();

  await dialog.waitFor({ state: 'detached' });
  const outside = await page.evaluate(() => {
    const { mode, widths } = window.latticed.scene!.session.lattice.outside!;
    return { mode, widths: [...widths] };
  });
  assert.equal(outside.mode, 'linear');
  // The box is a quarter of the first frame, 3.08 x 3.08 x 1.08, and the mesh is 2.8 x 2.8 x 0.8. The server adds a sixteenth.
  const reach = [2.8 / 0.77, 2.8 / 0.77, 0.8 / 0.27].flatMap((length) => new Array<number>(2).fill((17 / 16) * (length - 1) / 2));
  outside.widths.forEach((width, side) => assert.ok(Math.abs(width - reach[side]!) < 1e-6, `${outside.widths}`));
});

test('a lattice is added that is turned against the others, and what it moves adds up', async () => {
  await page.evaluate(() => window.latticed.scene!.session.chooseLattice(0));
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.outside === undefined);
  const count = await page.evaluate(() => window.latticed.scene!.session.latticeCount);
  const { u } = await page.evaluate(() => window.latticed.scene!.session.lattice.frame);
  await page.evaluate(() => window.latticed.scene!.addLattice());
  const dialog = page.locator('dialog.add-lattice');
  await dialog.getByRole('spinbutton', { name: 'Turn about z' }).fill('30');
  await shot('viewer_add_turned_lattice');
  await dialog.getByRole('button', { name: 'Add', exact: true }).click();

  await dialog.waitFor({ state: 'detached' });
  await page.waitForFunction((before) => window.latticed.scene!.session.latticeCount === before + 1, count);
  const { frame } = await page.evaluate(() => window.latticed.scene!.session.lattice);
  const expected = [u[0] / 2 * Math.cos(Math.PI / 6), u[0] / 2 * Math.sin(Math.PI / 6), 0];
  expected.forEach((x, axis) => assert.ok(Math.abs(frame.u[axis]! - x) < 1e-9, `${frame.u}`));
  const rest = await top();
  await select(...Array.from({ length: 64 }, (_, i) => i));
  await press('g', 'z', '1', 'Enter');
  await page.waitForFunction((least) => window.latticed.scene!.session.surface.bounds.max.z > least, rest + 0.5);
  assert.deepEqual(errors, []);
});

test('one that is turned shows within the tolerance of the page, and its moves add up too', async () => {
  await openTwo('turned-lattices', 0.5);
  await page.evaluate(() => window.latticed.settings.set({ detail: 'tolerance' }));
  await segmentsCome(page, 0); // patches of a tolerance have no segments in common
  const rest = await top();
  await page.getByRole('combobox', { name: 'Lattice', exact: true }).selectOption('2 of 2');
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.count === 27);
  await select(...Array.from({ length: 27 }, (_, i) => i));

  await press('g', 'z', '1', 'Enter');

  await page.waitForFunction((least) => window.latticed.scene!.session.surface.bounds.max.z > least, rest + 0.9);
  await segmentsCome(page, 0);
});

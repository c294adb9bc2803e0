// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Constraints in the viewer in Chromium: the volume is shown and kept; points and layers are held, and shown as such; the mirror
// is locked. They bind other windows and programs too.
// Environment: LATTICED, LATTICECTL, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import type { Color } from 'three';
import { LIGHT_CAGE } from '@src/cage/cage_style';
import { openPage } from '../support/browser';
import { browser, CORNER, direct, openTorus, page, press, select, server, shot, until, useStage } from '../support/stage';
import { colourAt, controlPoint, frames, live, onScreen } from '../support/viewer_page';

const POINT = 21;

const viewport = { width: 920, height: 560 }; // with the panel

useStage({ context: { viewport }, begin: openTorus });

function volume(): Promise<number> {
  return page.evaluate(() => window.latticed.scene!.session.measureVolume());
}

function constraintsCome(kept: boolean, held: number): Promise<unknown> {
  return page.waitForFunction(([k, h]) => {
    const { session } = window.latticed.scene!;
    return (session.constraints.volume !== undefined) === k && session.held.size === h;
  }, [kept, held] as const);
}

const sceneId = (): Promise<string> => page.evaluate(() => window.latticed.scene!.session.sceneId);

/** All control points of the scene, by the server. */
async function pointsAtServer(): Promise<number[]> {
  return (await direct.scenes.getLattice({ scene: await sceneId() })).lattice!.controlPoints;
}

/** Edits the scene by latticectl. */
async function latticectlEdits(edit: string, ...words: readonly string[]): Promise<void> {
  const all = ['edit', edit, await sceneId(), ...words, '--server', server.grpcAddress];
  execFileSync(process.env.LATTICECTL!, all, { stdio: ['ignore', 'ignore', 'inherit'] });
}

async function reset(): Promise<void> {
  await page.evaluate(() => window.latticed.scene!.session.reset('identity'));
  await page.waitForFunction(() => window.latticed.scene!.session.isAt(1_000));
}

/** Drags a control point of the page by the mouse, to the right and upwards. */
async function dragByMouse(index: number): Promise<void> {
  await frames(page);
  const [x, y] = await onScreen(page, index);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 30, y - 20, { steps: 3 });
  await page.mouse.up();
}

/** Waits until the server has a control point somewhere else than in `before`. Returns all control points. */
async function pointMoves(index: number, before: readonly number[]): Promise<number[]> {
  let now: number[] = [];
  await until(async () => {
    now = await pointsAtServer();
    return [0, 1, 2].some((axis) => now[3 * index + axis] !== before[3 * index + axis]);
  });
  return now;
}

const moveOf = (index: number, after: readonly number[], before: readonly number[]): number[] =>
  [0, 1, 2].map((axis) => after[3 * index + axis]! - before[3 * index + axis]!);

/** Asserts that two control points moved as mirror images over the x axis, and moved. */
function assertMirrored(index: number, image: number, after: readonly number[], before: readonly number[]): void {
  const [x, y, z] = moveOf(index, after, before);
  const [ix, iy, iz] = moveOf(image, after, before);
  assert.ok(Math.hypot(x!, y!, z!) > 0.01);
  assert.ok(Math.hypot(x! + ix!, y! - iy!, z! - iz!) < 1e-12, `${[x, y, z]}, image ${[ix, iy, iz]}`);
}

test('the volume is shown, and kept while the switch is on', async () => {
  await page.getByText(/^Volume -?\d/).waitFor();
  const rest = await volume();
  await page.getByText('Keep volume', { exact: true }).click();
  await constraintsCome(true, 0);
  await select(POINT);

  await press('g', '1', 'Enter');

  await page.waitForFunction(() => window.latticed.scene!.session.isAt(1_000));
  assert.ok(Math.abs((await volume()) / rest - 1) < 1e-12);
  await page.getByText('Keep volume', { exact: true }).click();
  await constraintsCome(false, 0);
});

test('held points stay where they are', async () => {
  await select(POINT);
  await page.getByRole('button', { name: 'Hold selected' }).click();
  await constraintsCome(false, 1);
  await page.getByText('Held control points: 1').waitFor();
  const before = await controlPoint(page, POINT);

  await press('g', '2', 'Enter'); // 2 is no key of the view, which gets it where nothing may move

  assert.deepEqual(await controlPoint(page, POINT), before);
  await page.getByRole('button', { name: 'Release all' }).click();
  await constraintsCome(false, 0);
});

test('a locked mirror moves the image of a dragged point, in this window, in others and for latticectl, until it is unlocked', async () => {
  const [image, low, lowImage] = [60, 0, 3]; // of CORNER; at the begin of all axes; its image
  const lock = page.locator('.constraints').getByRole('switch', { name: 'u', exact: true });
  const mirrorComes = (of: Page, axis: number | undefined): Promise<unknown> =>
    of.waitForFunction((wanted) => window.latticed.scene!.session.constraints.mirror === wanted, axis);
  await reset();
  await lock.click();
  await mirrorComes(page, 0);
  const rest = await pointsAtServer();

  await select(CORNER);
  await dragByMouse(CORNER);
  const dragged = await pointMoves(image, rest);
  assertMirrored(CORNER, image, dragged, rest);

  await latticectlEdits('move', '--point', '0,0,0', '--by', '0.25,0.5,0');
  const moved = await pointsAtServer();
  assert.deepEqual(moveOf(low, moved, dragged).map((x) => Math.round(1e9 * x) / 1e9), [0.25, 0.5, 0]);
  assertMirrored(low, lowImage, moved, dragged);

  const { page: other, errors } = await openPage(browser, page.url(), { viewport });
  await live(other);
  await mirrorComes(other, 0);
  await other.evaluate((index) => window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(index), offset: [0, 0, -0.5] }), low);
  const byOther = await pointMoves(lowImage, moved);
  assertMirrored(low, lowImage, byOther, moved);
  await other.locator('.constraints').getByRole('switch', { name: 'u', exact: true }).click();
  await mirrorComes(page, undefined);
  assert.equal(await lock.isChecked(), false);
  assert.deepEqual(errors, []);
  await other.close();

  await select(CORNER);
  await dragByMouse(CORNER);
  const alone = await pointMoves(CORNER, byOther);
  assert.deepEqual(moveOf(image, alone, byOther), [0, 0, 0]);
});

test('held layers are drawn as held, and neither a drag nor latticectl moves them; more layers are held of a larger lattice', async () => {
  const layers = page.getByRole('radiogroup', { name: 'Held layers at all faces' });
  await reset();
  await page.evaluate(() => window.latticed.scene!.editor.selection.none());
  await page.mouse.move(300, 500); // hovers no point
  const { plain, held } = LIGHT_CAGE.colours;
  const isDrawnAs = async (colour: Color): Promise<void> => {
    await frames(page);
    const drawn = await colourAt(page, await controlPoint(page, CORNER));
    const hex = colour.getHex();
    const wanted = [hex >> 16, (hex >> 8) & 255, hex & 255];
    assert.ok(wanted.every((part, i) => Math.abs(drawn[i]! - part) < 6), `drawn as ${drawn} in place of ${wanted}`);
  };
  await isDrawnAs(plain);
  await layers.getByRole('radio', { name: '1' }).click();
  await constraintsCome(false, 56);
  await page.getByText('Held control points: 56').waitFor();
  await page.mouse.move(300, 500);
  await isDrawnAs(held);
  await shot('viewer_held_layers');
  const rest = await pointsAtServer();

  await select(CORNER);
  await dragByMouse(CORNER);
  await latticectlEdits('move', '--point', '3,3,3', '--point', '1,1,1', '--by', '0,0,0.25');

  const moved = await pointMoves(POINT, rest);
  assert.deepEqual(moved.filter((x, i) => x !== rest[i]).length, 1, 'the z of the free point alone');
  await latticectlEdits('resize', '--size', '6,6,6');
  await constraintsCome(false, 6 ** 3 - 4 ** 3);
  await layers.getByRole('radio', { name: '2' }).click();
  await constraintsCome(false, 6 ** 3 - 2 ** 3);
  const larger = await pointsAtServer();
  await latticectlEdits('move', '--point', '1,1,4', '--point', '2,2,3', '--by', '0,0.25,0');
  const after = await pointMoves(2 + 6 * (2 + 6 * 3), larger);
  assert.equal(after.filter((x, i) => x !== larger[i]).length, 1);

  await layers.getByRole('radio', { name: 'None' }).click();
  await constraintsCome(false, 0);
  await select(215);
  await press('g', '1', 'Enter');
  await pointMoves(215, after);
});

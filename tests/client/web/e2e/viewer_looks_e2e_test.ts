// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What each look of the surface draws where, by the colours of pixels: a sheet in the plane of the screen, whose upper right
// corner one control point has pulled to the left, so that light is the same everywhere.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';
import { Color } from 'three';
import { add, distance, scale, type Vec3 } from '@src/lattice/vec';
import { deformed, followsDefinition, shownBy, type Shown } from './definition';
import { errors, page, shot, useStage } from './stage';
import { changesView, createScene, dropFiles, meshUploaded, placeOf, segmentsCome } from './viewer_page';

const CORNER = 31; // the last of 4 x 4 x 2 control points
const PULL: Vec3 = [-1, 0, 0];
const OUTSIDE: readonly Vec3[] = [[1.05, 0.95, 0], [0.95, 1.05, 0], [-1.05, -0.5, 0]];
const SAME = 3; // levels of 255 that colours of one thing may differ by
const BROAD = 30; // pixels that a patch is wide, at the least, where its lines are told apart
const SEGMENTS = 3;

let shown: Shown;
let background: Vec3;
let plain: Vec3;

/** 3 x 3 squares over -1 to 1, of two triangles each: the planes between knot boxes cut those in the middle. */
function sheet(): string {
  const vertices = Array.from({ length: 16 }, (_, i) => `v ${(2 * (i % 4)) / 3 - 1} ${(2 * Math.floor(i / 4)) / 3 - 1} 0`);
  const faces = [0, 1, 2, 4, 5, 6, 8, 9, 10].flatMap((i) => [`f ${i + 1} ${i + 2} ${i + 6}`, `f ${i + 1} ${i + 6} ${i + 5}`]);
  return [...vertices, ...faces].join('\n');
}

/** The colours of the view, 0 to 255, where points of the world are. */
function coloursAt(points: readonly Vec3[]): Promise<Vec3[]> {
  return page.evaluate((list) => {
    const { viewport } = window.latticed;
    viewport.renderer.render(viewport.scene, viewport.rig.camera);
    const gl = viewport.renderer.getContext();
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const all = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, all);
    const ratio = viewport.renderer.getPixelRatio();
    return list.map((p) => {
      const [x, y] = viewport.project(p)!.map((value) => Math.floor(value * ratio));
      return [...all.subarray(4 * (x + width * (height - 1 - y))).subarray(0, 3)] as unknown as Vec3;
    });
  }, points);
}

/** Where places of the mesh are now. */
const moved = (places: readonly Vec3[]): Vec3[] => places.map((place) => deformed(shown.lattice, place));

function assertAll(colours: readonly Vec3[], wanted: Vec3, what: string): void {
  assert.ok(colours.length > 0, what);
  for (const colour of colours) assert.ok(distance(colour, wanted) <= SAME, `${what}: ${colour} is not ${wanted}`);
}

/** Draws with other settings than plain ones, from when that is seen. */
function look(settings: object): Promise<void> {
  return changesView(page, 500, () => page.evaluate((other) => window.latticed.settings.set(other), settings));
}

useStage({
  begin: async () => {
    await dropFiles(page, [['sheet.obj', sheet()]]);
    await meshUploaded(page);
    await page.getByLabel('Degree along w').selectOption('1');
    await page.getByLabel('Points along w').fill('2');
    await page.getByLabel('Points along w').press('Tab');
    await createScene(page);
    await page.evaluate(([corner, offset, segments]) => {
      const { settings, viewport, scene } = window.latticed;
      settings.set({ theme: 'dark', orthographic: true, cage: false, gizmo: 'none', view: { ...settings.value.view, segments } });
      viewport.rig.lookFrom([0, -1e-3, 1]);
      scene!.frameAll();
      scene!.session.apply({ kind: 'move', indices: Uint32Array.of(corner), offset });
    }, [CORNER, PULL, SEGMENTS] as const);
    await segmentsCome(page, SEGMENTS);
    await followsDefinition(page, sheet());
    shown = await shownBy(page);
    [background, plain] = await coloursAt([OUTSIDE[0], [-0.5, -0.4, 0]]);
  },
});

afterEach(async () => {
  await page.evaluate(() => window.latticed.settings.set({ colouring: 'plain', ghost: false, wireframe: false, patchEdges: false }));
});

/** What a colour of the heat map is called. */
function hue(colour: Vec3): string {
  const { r, g, b } = new Color().setRGB(colour[0] / 255, colour[1] / 255, colour[2] / 255, 'srgb');
  if (r > 2 * g && r > 2 * b) return 'red';
  if (r > 2 * b && g > 2 * b) return 'yellow';
  if (g > 1.2 * r && g > 1.2 * b) return 'green';
  if (b > 1.2 * g && g > 2 * r) return 'blue';
  return b > 2 * g && b > 2 * r ? 'dark blue' : `${colour}`;
}

test('a heat map whose first call is lost is said to be missing, and is there once the page has connected again', async () => {
  const CALL = '**/latticed.v1.SceneService/CreateScene';
  await page.route(CALL, (route) => route.abort());
  await page.evaluate(() => window.latticed.settings.set({ colouring: 'displacement' }));
  await page.locator('.toast-error').getByText('Displacement, knot boxes and rest shape cannot be shown.').waitFor();
  await page.unroute(CALL);
  errors.length = 0; // the lost call is in the console too

  await page.evaluate(() => window.dispatchEvent(new Event('online')));

  await page.waitForFunction(() => window.latticed.scene!.session.surface.displacementRange > 0);
  assert.equal(hue((await coloursAt([[-0.95, -0.95, 0]]))[0]), 'dark blue');
  await page.locator('.toast-error').getByRole('button', { name: 'Close' }).click();
});

test('the heat map is red at the corner that was moved, cold at the others, and its legend says how far that is', async () => {
  const corner: Vec3 = [1, 1, 0];
  const most = distance(deformed(shown.lattice, corner), corner);
  /** Where the diagonal has moved by a fraction of that. */
  const placeMoved = (fraction: number): Vec3 => {
    let [low, high] = [0, 1];
    for (let step = 0; step < 40; ++step) {
      const middle = (low + high) / 2;
      const place: Vec3 = [middle, middle, 0];
      if (distance(deformed(shown.lattice, place), place) < fraction * most) low = middle;
      else high = middle;
    }
    return [low, low, 0];
  };
  await look({ colouring: 'displacement' });

  const colours = await coloursAt(moved([0.95, 0.75, 0.5, 0.25].map(placeMoved)));
  const cold = await coloursAt(moved([[-0.95, -0.95, 0], [0.95, -0.95, 0], [-0.95, 0.95, 0], [-0.2, -0.2, 0]]));
  await shot('viewer_look_heat');

  assert.deepEqual(colours.map(hue), ['red', 'yellow', 'green', 'blue']);
  assert.deepEqual(cold.map(hue), Array(4).fill('dark blue'));
  await page.locator('.heat-legend').waitFor(); // with the next frame
  const end = Number(await page.locator('.heat-legend span').last().innerText());
  assert.ok(Math.abs(end / most - 1) < 0.01, `${end} is not ${most}`);
});

test('the ghost tints where the rest shape is and the deformed one is not, and nothing beside it', async () => {
  const left: readonly Vec3[] = [[0.85, 0.9, 0], [0.95, 0.95, 0], [0.95, 0.8, 0]]; // by the surface
  const both: readonly Vec3[] = [[-0.9, -0.9, 0], [0.2, -0.7, 0], [0.3, 0.9, 0]];
  assertAll(await coloursAt([...OUTSIDE, ...left]), background, 'without a ghost');
  assertAll(await coloursAt(both), plain, 'the surface');

  await look({ ghost: true });
  const tint = add(scale(background, 0.8), scale(plain, 0.2)); // it lets most through
  await shot('viewer_look_ghost');

  assert.ok(distance(tint, background) > 5 * SAME, `${tint}`);
  assertAll(await coloursAt(left), tint, 'the ghost');
  assertAll(await coloursAt(OUTSIDE), background, 'outside');
  assertAll(await coloursAt(both), plain, 'on the surface');
});

test('every knot box has one colour, of all patches in it, and no other has the same', async () => {
  const along = Array.from({ length: 40 }, (_, i) => -0.975 + 0.05 * i); // none in the planes between boxes
  const boxes = [[-1, -1], [1, -1], [-1, 1], [1, 1]].map(([x, y]) =>
    along.filter((a) => a * x > 0).flatMap((a) => along.filter((b) => b * y > 0).map((b): Vec3 => [a, b, 0])));
  await look({ colouring: 'boxes' });

  const colours: Vec3[] = [];
  for (const [i, places] of boxes.entries()) {
    const found = await coloursAt(moved(places));
    assert.equal(found.length, 400);
    assertAll(found, found[0], `box ${i}`);
    colours.push(found[0]);
  }
  await shot('viewer_look_boxes');

  for (const [i, one] of [...colours, plain, background].entries()) {
    for (const other of [...colours, plain, background].slice(0, i)) assert.ok(distance(one, other) > 5 * SAME, `${one}, ${other}`);
  }
});

interface Places {
  /** On edges that two patches share. */
  readonly edges: Vec3[];
  /** On lines between points of a patch, off its edges. */
  readonly lines: Vec3[];
  /** In the middle of a patch's triangles. */
  readonly cells: Vec3[];
}

/** Places of patches that are broad enough on the screen. */
async function placesOnPatches(): Promise<Places> {
  const { points, pattern } = shown;
  const triangles = await page.evaluate(() =>
    [...window.latticed.scene!.session.surface.layout!.patternTriangles]);
  const pixels = distance([...(await placeOf(page, [1, 0, 0])), 0], [...(await placeOf(page, [0, 0, 0])), 0]); // of a unit
  const count = pattern.length / 3;
  const onEdge = (...numbers: number[]): boolean => [0, 1, 2].some((k) => numbers.every((n) => pattern[3 * n + k] === 0));
  const middle = (...all: Vec3[]): Vec3 => scale(all.reduce(add), 1 / all.length);
  const edges: Vec3[] = [];
  const found: Places = { edges: [], lines: [], cells: [] };
  for (let first = 0; first < points.length; first += count) {
    const at = (n: number): Vec3 => points[first + n];
    if (pixels * breadth(at(0), at(SEGMENTS), at(count - 1)) < BROAD) continue;
    for (let i = 0; i < triangles.length; i += 3) {
      const corners = triangles.slice(i, i + 3);
      found.cells.push(middle(...corners.map(at)));
      for (const [a, b] of [[0, 1], [1, 2], [2, 0]].map((ends) => ends.map((end) => corners[end]))) {
        (onEdge(a, b) ? edges : found.lines).push(middle(at(a), at(b)));
      }
    }
  }
  // The outermost are seen from one side only, and may be beside their pixel.
  found.edges.push(...edges.filter((edge) => edges.filter((other) => distance(edge, other) < 4 * shown.step).length > 1));
  return found;
}

/** The least altitude of a triangle in the plane of the screen. */
function breadth([ax, ay]: Vec3, [bx, by]: Vec3, [cx, cy]: Vec3): number {
  const area = Math.abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax));
  return area / Math.max(Math.hypot(bx - ax, by - ay), Math.hypot(cx - bx, cy - by), Math.hypot(ax - cx, ay - cy));
}

const brightness = ([r, g, b]: Vec3): number => (r + g + b) / 3;

test('lines lie on the edges of patches and not inside; those of the wireframe inside too, between its triangles', async () => {
  const { edges, lines, cells } = await placesOnPatches();
  assert.ok(edges.length > 40 && lines.length > 40 && cells.length > 40, `${[edges.length, lines.length, cells.length]}`);
  assertAll(await coloursAt([...edges, ...lines, ...cells]), plain, 'without lines');

  await look({ patchEdges: true });
  const onEdges = await coloursAt(edges);
  assertAll(await coloursAt([...lines, ...cells]), plain, 'inside a patch');
  await shot('viewer_look_edges');
  await look({ patchEdges: false, wireframe: true });
  const onLines = await coloursAt([...edges, ...lines]);
  assertAll(await coloursAt(cells), plain, 'inside a triangle');
  await shot('viewer_look_wireframe');

  for (const colour of onEdges) assert.ok(brightness(colour) < 0.6 * brightness(plain), `${colour}, where ${plain} is the surface`);
  for (const colour of onLines) assert.ok(brightness(colour) < 0.95 * brightness(plain), `${colour}, where ${plain} is the surface`);
  assert.deepEqual(errors, []);
});

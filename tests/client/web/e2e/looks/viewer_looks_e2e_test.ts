// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Checks each look of the surface by the colours of pixels. Most tests show a flat sheet in the plane of the
// screen, which is lit evenly. One control point has pulled its upper right corner to the left. The last tests pull a
// surface that cannot follow, and shade a roof by each kind of normals.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';
import { Color } from 'three';
import { add, distance, scale, type Vec3 } from '@src/lattice/vec';
import { latticeToJson } from '@src/wire/lattice_json';
import { deformed, followsDefinition, shownBy, type Shown } from '../support/definition';
import { picture } from '../support/picture';
import { plainSheetObj } from '../support/sheet';
import { errors, page, press, setView, shot, until, useStage } from '../support/stage';
import { changesView, colourAt, createScene, dropFiles, frames, latticeIn, live, meshUploaded, placeOf, segmentsCome } from '../support/viewer_page';

const CORNER = 31; // the last of 4 x 4 x 2 control points
const PULL: Vec3 = [-1, 0, 0];
const OUTSIDE: readonly Vec3[] = [[1.05, 0.95, 0], [0.95, 1.05, 0], [-1.05, -0.5, 0]];
const SAME = 3; // RGB distance, at 255 per channel, by which colours of one thing may differ
const BROAD = 30; // the least width, in pixels, of a patch whose lines are checked
const SEGMENTS = 3;

let shown: Shown;
let background: Vec3;
let plain: Vec3;

/** 3 x 3 squares of two triangles each over -1 to 1. The planes between knot boxes cut the squares in the middle. */
function sheet(): string {
  const vertices = Array.from({ length: 16 }, (_, i) => `v ${(2 * (i % 4)) / 3 - 1} ${(2 * Math.floor(i / 4)) / 3 - 1} 0`);
  const faces = [0, 1, 2, 4, 5, 6, 8, 9, 10].flatMap((i) => [`f ${i + 1} ${i + 2} ${i + 6}`, `f ${i + 1} ${i + 6} ${i + 5}`]);
  return [...vertices, ...faces].join('\n');
}

/** The colours of the view, 0 to 255, at points of the world. */
async function coloursAt(points: readonly Vec3[]): Promise<Vec3[]> {
  const { width, height, pixels } = await picture(page);
  const places = await page.evaluate((list) => {
    const { viewport } = window.latticed;
    const ratio = viewport.renderer.getPixelRatio();
    return list.map((p) => viewport.project(p)!.map((value) => Math.floor(value * ratio)));
  }, points);
  return places.map(([x, y]) => [...pixels.subarray(4 * (x + width * (height - 1 - y))).subarray(0, 3)] as unknown as Vec3);
}

/** The positions to which the lattice moves these places of the mesh. */
const moved = (places: readonly Vec3[]): Vec3[] => places.map((place) => deformed(shown.lattice, place));

function assertAll(colours: readonly Vec3[], wanted: Vec3, what: string): void {
  assert.ok(colours.length > 0, what);
  for (const colour of colours) assert.ok(distance(colour, wanted) <= SAME, `${what}: ${colour} is not ${wanted}`);
}

/** Changes the look, and waits until the view shows it. */
function look(settings: object): Promise<void> {
  return changesView(page, 500, () => page.evaluate((other) => window.latticed.settings.set(other), settings));
}

/** Like look(), by the look's key. */
function toggle(key: string): Promise<void> {
  return changesView(page, 500, () => press(key));
}

useStage({
  context: { viewport: { width: 800, height: 600 } }, // single pixels are looked at
  begin: async () => {
    await dropFiles(page, [['sheet.obj', sheet()]]);
    await meshUploaded(page);
    await page.getByLabel('Degree along w').selectOption('1');
    await page.getByLabel('Points along w').fill('2');
    await page.getByLabel('Points along w').press('Tab');
    await createScene(page);
    await page.evaluate(([corner, offset, segments]) => {
      const { settings, viewport, scene } = window.latticed;
      settings.set({ theme: 'dark', orthographic: true, cage: false, gizmo: 'none', detail: 'segments' });
      settings.set({ view: { ...settings.value.view, segments } });
      viewport.rig.lookFrom([0, -1e-3, 1]);
      scene!.frameAll();
      scene!.session.apply({ kind: 'move', indices: Uint32Array.of(corner), offset });
    }, [CORNER, PULL, SEGMENTS] as const);
    await segmentsCome(page, SEGMENTS);
    await followsDefinition(page, sheet());
    shown = await shownBy(page);
    await frames(page); // a frame takes in the points that have come
    [background, plain] = await coloursAt([OUTSIDE[0], [-0.5, -0.4, 0]]);
  },
});

afterEach(async () => {
  await page.evaluate(() => window.latticed.settings.set({ colouring: 'plain', ghost: false, wireframe: false, patchEdges: false }));
});

/** The name of a colour of the heat map. */
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
  errors.length = 0; // the console reports the lost call too

  await page.evaluate(() => window.dispatchEvent(new Event('online')));

  await page.waitForFunction(() => window.latticed.scene!.session.surface.displacementRange > 0);
  assert.equal(hue((await coloursAt([[-0.95, -0.95, 0]]))[0]), 'dark blue');
  await page.locator('.toast-error').getByRole('button', { name: 'Close' }).click();
});

test('the heat map is red at the corner that was moved, cold at the others, and its legend says how far that is', async () => {
  const corner: Vec3 = [1, 1, 0];
  const most = distance(deformed(shown.lattice, corner), corner);
  /** The place on the diagonal that has moved by this fraction of `most`. */
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
  await page.locator('.heat-legend').waitFor(); // it comes with the next frame
  const end = Number(await page.locator('.heat-legend span').last().innerText());
  assert.ok(Math.abs(end / most - 1) < 0.01, `${end} is not ${most}`);
});

test('the ghost tints where the rest shape is and the deformed one is not, and nothing beside it', async () => {
  const left: readonly Vec3[] = [[0.85, 0.9, 0], [0.95, 0.95, 0], [0.95, 0.8, 0]]; // places that the surface has left
  const both: readonly Vec3[] = [[-0.9, -0.9, 0], [0.2, -0.7, 0], [0.3, 0.9, 0]];
  assertAll(await coloursAt([...OUTSIDE, ...left]), background, 'without a ghost');
  assertAll(await coloursAt(both), plain, 'the surface');

  await toggle('t');
  const tint = add(scale(background, 0.8), scale(plain, 0.2)); // the ghost is 20 % opaque
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
  for (const key of 'jjcc') await toggle(key); // shows and hides the edges of boxes, then the cage
});

interface Places {
  /** Points on edges that two patches share. */
  readonly edges: Vec3[];
  /** Points on lines between points of a patch, but not on its edges. */
  readonly lines: Vec3[];
  /** The middle of each triangle of a patch. */
  readonly cells: Vec3[];
}

/** Places on patches that are wide enough on the screen. */
async function placesOnPatches(): Promise<Places> {
  const { points, spots } = shown;
  const triangles = await page.evaluate(() =>
    [...window.latticed.scene!.session.surface.layout!.patternOf(0).details[0]]);
  const pixels = distance([...(await placeOf(page, [1, 0, 0])), 0], [...(await placeOf(page, [0, 0, 0])), 0]); // a unit
  const count = ((SEGMENTS + 1) * (SEGMENTS + 2)) / 2;
  const onEdge = (...numbers: number[]): boolean => [0, 1, 2].some((k) => numbers.every((n) => spots[n].weights[k] === 0));
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
  // An edge on the rim belongs to one patch only, and may miss its pixel: it is left out.
  found.edges.push(...edges.filter((edge) => edges.filter((other) => distance(edge, other) < 4 * shown.step).length > 1));
  return found;
}

/** The smallest altitude of a triangle in the plane of the screen. */
function breadth([ax, ay]: Vec3, [bx, by]: Vec3, [cx, cy]: Vec3): number {
  const area = Math.abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax));
  return area / Math.max(Math.hypot(bx - ax, by - ay), Math.hypot(cx - bx, cy - by), Math.hypot(ax - cx, ay - cy));
}

const brightness = ([r, g, b]: Vec3): number => (r + g + b) / 3;

test('lines lie on the edges of patches and not inside; those of the wireframe inside too, between its triangles', async () => {
  const { edges, lines, cells } = await placesOnPatches();
  assert.ok(edges.length > 40 && lines.length > 40 && cells.length > 40, `${[edges.length, lines.length, cells.length]}`);
  assertAll(await coloursAt([...edges, ...lines, ...cells]), plain, 'without lines');

  await toggle('e');
  const onEdges = await coloursAt(edges);
  assertAll(await coloursAt([...lines, ...cells]), plain, 'inside a patch');
  await shot('viewer_look_edges');
  await toggle('e');
  await toggle('z');
  const onLines = await coloursAt([...edges, ...lines]);
  assertAll(await coloursAt(cells), plain, 'inside a triangle');
  await shot('viewer_look_wireframe');

  for (const colour of onEdges) assert.ok(brightness(colour) < 0.6 * brightness(plain), `${colour}, where ${plain} is the surface`);
  for (const colour of onLines) assert.ok(brightness(colour) < 0.95 * brightness(plain), `${colour}, where ${plain} is the surface`);
});

/** Looks at the open scene from above, without its cage. */
async function lookFromAbove(): Promise<void> {
  await page.evaluate(() => {
    window.latticed.settings.set({ cage: false, gizmo: 'none', orthographic: true });
    window.latticed.viewport.rig.lookFrom([0, -1e-3, 1]);
    window.latticed.scene!.frameAll();
  });
  await frames(page);
}

/** The ends of the line from the pulled point to its target out of reach, in pixels of the page. */
function pullLine(): Promise<number[]> {
  return page.evaluate(() => {
    const line = document.querySelector('.pull-line line')!;
    const box = window.latticed.viewport.canvas.getBoundingClientRect();
    return ['x1', 'y1', 'x2', 'y2'].map((name, i) => Number(line.getAttribute(name)) + (i % 2 === 0 ? box.left : box.top));
  });
}

test('what lies outside the lattice is out of reach of a pull: a line and words say how far, until Escape', async () => {
  await dropFiles(page, [['sheet.obj', plainSheetObj()]]);
  await createScene(page);
  const half = latticeIn([[0, -1.2, -1], [1.2, 0, 0], [0, 2.4, 0], [0, 0, 2]], 3, 2); // around the right half
  await dropFiles(page, [['half.json', latticeToJson(half)]]);
  await page.waitForFunction(() => window.latticed.scene!.session.lattice.size.join() === '3,3,3');
  await live(page);
  await lookFromAbove();
  await page.keyboard.press('p');

  const [x, y] = await placeOf(page, [-0.6, 0.1, 0]);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60, y - 40, { steps: 4 });
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
  await page.keyboard.press('p');
});

/** Two planes at right angles, whose ridge goes along y. */
const ROOF = ['-1 -1 0', '-1 1 0', '0 -1 1', '0 1 1', '1 -1 0', '1 1 0'].map((at) => `v ${at}\n`).join('') + 'f 1 3 4 2\nf 3 5 6 4\n';

/** The roof's colours: left and right of the ridge, then beside that, and near the right eaves. */
async function roofColours(): Promise<Vec3[]> {
  const colours: Vec3[] = [];
  for (const x of [-0.04, 0.04, 0.3, 0.9]) colours.push(await colourAt(page, [x, 0.1, 1 - Math.abs(x)]));
  return colours;
}

const EDGE = 30; // the RGB distance, at 255 per channel, at which a person sees an edge
const FLAT = 6;

test('facets are flat with an edge between them, smooth normals hide it below the crease angle, and without normals facets are shaded', async () => {
  await dropFiles(page, [['roof.obj', ROOF]]);
  await page.getByLabel('Crease angle').fill('180');
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
      const [left, right, aside, eaves] = await roofColours();
      return hasEdge
        ? distance(left, right) > EDGE && distance(aside, eaves) < FLAT
        : distance(left, right) < FLAT && distance(right, eaves) > 1.5 * FLAT;
    }, async () => `${mode}: ${(await roofColours()).join(' ')}`);
    shades.push(await roofColours());
    await shot(`viewer_roof_${mode}`);
  }
  const [, facet, none] = shades;
  facet.slice(2).forEach((colour, i) => assert.ok(distance(colour, none[i + 2]) < FLAT, `${colour} and ${none[i + 2]}`));

  await dropFiles(page, [['roof.obj', ROOF]]);
  await createScene(page); // 30 degrees
  await setView({ normals: 'smooth', segments: 6 });
  await lookFromAbove();
  await until(async () => {
    const [left, right, aside, eaves] = await roofColours();
    return distance(left, right) > EDGE && distance(aside, eaves) < FLAT;
  }, async () => `smooth, with an edge: ${(await roofColours()).join(' ')}`);
  assert.deepEqual(errors, []);
});

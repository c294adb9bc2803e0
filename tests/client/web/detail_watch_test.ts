// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The view that a page asks for, as the camera and the settings change.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Box3, OrthographicCamera, PerspectiveCamera, Vector3 } from 'three';
import { DetailWatch, firstView, segmentsFor } from '@src/detail_watch';
import type { LiveSession } from '@src/session/live_session';
import type { ViewRequest } from '@src/session/scene_session';
import { DEFAULT_SETTINGS, type Settings } from '@src/state/settings';
import { Store } from '@src/state/store';
import { leastTolerance, meetsTolerance } from '@src/surface/grid_tolerance';
import type { ViewCamera } from '@src/viewport/camera_rig';
import { pixelSize } from '@src/viewport/pixel_size';
import type { Viewport } from '@src/viewport/viewport';

const HEIGHT = 1000;
/** As where the page's GPU cannot evaluate patches. */
const WITH_POINTS: Settings = { ...DEFAULT_SETTINGS, view: { ...DEFAULT_SETTINGS.view, encoding: 'draco' } };
const boxes = (...list: Box3[]) => (visit: (box: Box3) => void): void => list.forEach((box) => visit(box.clone()));
const cube = (x: number, y: number, z: number, half = 1): Box3 =>
  new Box3(new Vector3(x - half, y - half, z - half), new Vector3(x + half, y + half, z + half));

/** Looks along -z from `z`, with a focal length of HEIGHT pixels and a square picture. */
function perspective(z: number): PerspectiveCamera {
  const camera = new PerspectiveCamera((2 * Math.atan(0.5) * 180) / Math.PI, 1, 0.1, 1000);
  camera.position.set(0, 0, z);
  return camera;
}
const CORNER = Math.sqrt(1 + 0.5 ** 2 + 0.5 ** 2); // 1 / cos of the angle to the picture's corner

test('a pixel shows the depth of the nearest part in view over the focal length; what is not in view does not count', () => {
  const near = (value: number | undefined, wanted: number): void => assert.ok(Math.abs(value! / wanted - 1) < 1e-6, `${value}, not ${wanted}`);
  near(pixelSize(perspective(11), HEIGHT, boxes(cube(0, 0, 0), cube(0, 0, -20))), 10 / HEIGHT / CORNER);
  near(pixelSize(perspective(11), HEIGHT, boxes(cube(0, 0, 0), cube(50, 0, 8), cube(0, 0, 30))), 10 / HEIGHT / CORNER);
  near(pixelSize(perspective(0.5), HEIGHT, boxes(cube(0, 0, 0))), 0.1 / HEIGHT / CORNER); // inside: the near plane
  assert.equal(pixelSize(perspective(11), HEIGHT, boxes(cube(50, 0, 0))), undefined);
  const orthographic = new OrthographicCamera(-4, 4, 4, -4, 0.1, 100);
  orthographic.position.set(0, 0, 11);
  orthographic.zoom = 2;
  orthographic.updateProjectionMatrix();
  near(pixelSize(orthographic, HEIGHT, boxes(cube(0, 0, 0))), 4 / HEIGHT);
});

test('points of 12 bits meet what two thirds of a tolerance leave them; no bits meet less than those of 16', () => {
  const range = 4095 * 0.002; // a step of 0.002: points are off by sqrt(3) / 2 of it, and by 3e-7 of the range on each axis
  const error = Math.sqrt(3) * (0.001 + 3e-7 * range);
  assert.ok(meetsTolerance(1.501 * error, range, 12) && !meetsTolerance(1.499 * error, range, 12));
  assert.ok(meetsTolerance(1.001 * leastTolerance(range), range, 16) && !meetsTolerance(0.999 * leastTolerance(range), range, 16));
});

test('segments are fewer for more patches; the first tolerance follows from the size of the mesh', () => {
  assert.deepEqual([1, 6000, 17_068, 1e6].map((patches) => segmentsFor(patches)), [32, 10, 5, 2]);
  assert.equal(segmentsFor(1, 10), 10);
  const { tolerance, segments, positionBits } = firstView(WITH_POINTS, { diagonal: 10, patches: 6000 }, HEIGHT, false);
  assert.deepEqual([tolerance, segments, positionBits], [2 ** -9, 10, 0]); // 0.5 pixels of 6 units over 1000 are 0.003
  const unknown = firstView(WITH_POINTS, { diagonal: 0, patches: 0 }, HEIGHT, false);
  assert.deepEqual([unknown.tolerance, unknown.segments], [0, 10]);
  const bySegments = firstView({ ...WITH_POINTS, detail: 'segments' }, { diagonal: 10, patches: 6000 }, HEIGHT, false);
  assert.equal(bySegments.tolerance, 0);
  const evaluated = firstView(DEFAULT_SETTINGS, { diagonal: 10, patches: 6000 }, HEIGHT, true);
  assert.deepEqual([evaluated.encoding, evaluated.tolerance], ['patches', 0]);
});

/** A watch of a cube of two units before a camera that looks at it, and what it has asked for. */
class Watched {
  readonly asked: ViewRequest[] = [];
  readonly settings = new Store<Settings>({ ...WITH_POINTS });
  readonly camera = perspective(11);
  readonly surface = { layout: {} as object | undefined, patchCount: 6000, grid: { range: 4 }, bounds: cube(0, 0, 0), eachBox: boxes(cube(0, 0, 0)) };
  readonly listeners: Record<string, (data: object) => void> = {};
  askedView: ViewRequest;
  readonly watch: DetailWatch;

  constructor(asked: ViewRequest = { ...WITH_POINTS.view, tolerance: 2 ** -8, segments: 10, positionBits: 0, maxPoints: 100_000 },
    evaluatesPatches = false) {
    this.askedView = asked;
    const own = this;
    const session = {
      surface: this.surface,
      get askedView() {
        return own.askedView;
      },
      setView: (view: ViewRequest) => {
        this.asked.push(view);
        this.askedView = { ...this.askedView, ...view };
      },
      on: (name: string, listener: (data: object) => void) => {
        this.listeners[name] = listener;
        return () => undefined;
      },
    };
    const viewport = { rig: { camera: this.camera as ViewCamera }, pictureHeight: HEIGHT, evaluatesPatches };
    this.watch = new DetailWatch(session as unknown as LiveSession, this.settings, viewport as unknown as Viewport);
  }

  /** The tolerances asked for by looking from these depths in turn. */
  lookFrom(...depths: number[]): (number | undefined)[] {
    return depths.flatMap((depth) => {
      const before = this.asked.length;
      this.camera.position.z = 1 + depth;
      this.watch.ask();
      return this.asked.slice(before).map(({ tolerance }) => tolerance);
    });
  }
}

test('a finer tolerance is asked for where the camera needs it, and a coarser one where four times as much suffices', () => {
  const watched = new Watched();
  // 0.5 pixels are 2^-8 at a depth of 9.57.
  assert.deepEqual(watched.lookFrom(10, 12, 18, 30, 38), []);
  assert.deepEqual(watched.lookFrom(39), [2 ** -6]);
  assert.deepEqual(watched.lookFrom(38.5, 100, 38), [2 ** -7]);
  assert.deepEqual(watched.lookFrom(39, 60, 76, 20), []);
  assert.deepEqual(watched.lookFrom(5), [2 ** -9]);
  watched.settings.set({ pixels: 1 }); // no longer the same wish
  assert.equal(watched.askedView.tolerance, 2 ** -8);
});

test('points are asked for if patches cannot be evaluated, also before anything is drawn', () => {
  const watched = new Watched({ ...DEFAULT_SETTINGS.view, tolerance: 0, maxPoints: 0 }, true);
  watched.surface.layout = undefined;
  watched.settings.set({ view: DEFAULT_SETTINGS.view });
  assert.deepEqual(watched.asked, []);
  watched.watch.needsPoints();
  assert.deepEqual([watched.askedView.encoding, watched.askedView.tolerance], ['auto', 0]);
  watched.surface.layout = {};
  watched.watch.ask();
  assert.equal(watched.askedView.tolerance, 2 ** -8);
});

test('bits stay as they are chosen where they meet the tolerance, else the server chooses', () => {
  const watched = new Watched();
  watched.lookFrom(40);
  assert.equal(watched.askedView.positionBits, 12);
  watched.lookFrom(0.3);
  assert.equal(watched.askedView.positionBits, 0);
  watched.settings.set({ view: { ...watched.settings.value.view, positionBits: 16 } });
  assert.equal(watched.askedView.positionBits, 16);
});

test('a surface that may have no more points is not asked to be finer; no tolerance is finer than the grid', () => {
  const watched = new Watched();
  watched.listeners['update']!({ fullDetail: true, certifiedError: 2 ** -7 });
  assert.deepEqual(watched.lookFrom(5), []);
  watched.listeners['update']!({ fullDetail: true, certifiedError: 2 ** -9 });
  assert.deepEqual(watched.lookFrom(5), [2 ** -9]);
  const [least] = watched.lookFrom(1e-3);
  assert.ok(least! >= leastTolerance(4) && least! < 4 * leastTolerance(4), `${least}`);
});

test('while control points move a surface of many points may be coarser; with segments, nothing of this is asked', () => {
  const watched = new Watched();
  watched.lookFrom(100);
  assert.equal(watched.askedView.maxPoints, 100_000);
  Object.assign(watched.surface, { patchCount: 100_000 });
  watched.lookFrom(100);
  assert.equal(watched.askedView.maxPoints, 600_000); // more than a view of 1 segment
  watched.settings.set({ detail: 'segments' });
  const { tolerance, segments, maxPoints, positionBits } = watched.askedView;
  assert.deepEqual([tolerance, segments, maxPoints, positionBits], [0, 10, 0, 12]);
});

test('a tolerance that the server refuses is not asked for again, until something else is chosen', () => {
  const watched = new Watched();
  const refuse = (granted: ViewRequest): void => {
    watched.askedView = granted;
    watched.listeners['view']!(granted);
    watched.asked.length = 0;
  };
  refuse({ ...watched.askedView, tolerance: 0, segments: 4, maxPoints: 0, positionBits: 12 });
  assert.deepEqual(watched.lookFrom(10, 100, 3), []);
  assert.equal(watched.settings.value.view.segments, 4);
  watched.settings.set({ pixels: 2 });
  assert.ok(watched.askedView.tolerance! > 0);

  watched.settings.set({ pixels: 0.5 });
  refuse({ ...watched.askedView, tolerance: 2 ** -7 }); // a coarser one than that asked for, which would take too much memory
  assert.deepEqual(watched.lookFrom(5, 1), []);
  assert.deepEqual(watched.lookFrom(100), [2 ** -5]);
});

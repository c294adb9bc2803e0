// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The evaluation of patches on the GPU, in Chromium, read back and compared with the definition in double precision.
// Environment: LATTICED, CHROMIUM; LATTICED_PAGE, the folder of the page.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { NormalMode } from 'latticed/v1/view_pb';
import type { Axes } from '@src/lattice/grid';
import { closeContexts, launch, openPage } from '../support/browser';
import type {} from '../page/harness'; // window.comparePatches
import { ServerProcess } from '../support/server_process';

/** Of the diagonal. A step of float32 is 6e-8 of half of it; 4.2e-8 was measured. */
const POSITION = 1e-7;
/** In radians, of float32 derivatives; 6.2e-6 was measured, where the lattice nearly folds. */
const NORMAL = 2e-5;

let server: ServerProcess;
let browser: Browser;
let page: Page;
let errors: string[];

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_PAGE!);
  browser = await launch();
  ({ page, errors } = await openPage(browser, server.origin));
});

after(async () => {
  await closeContexts();
  await server?.kill();
});

const DEGREES: readonly Axes[] = [[1, 1, 1], [2, 2, 2], [3, 3, 3], [1, 2, 3], [2, 3, 1], [3, 1, 2], [3, 2, 2], [1, 1, 2]];
for (const [seed, degree] of DEGREES.entries()) {
  for (const mode of [NormalMode.FACET, NormalMode.SMOOTH]) {
    test(`degrees ${degree.join(' x ')}, ${NormalMode[mode].toLowerCase()} normals: all points are those of the definition, and shared ones the same bits`, async () => {
      const found = await page.evaluate((of) => window.comparePatches(...of), [seed, degree, mode, false] as const);

      assert.ok(found.points > 500 && found.shared > 100 && found.sharedOnSeam > 5, JSON.stringify(found));
      assert.equal(found.differing, 0);
      assert.equal(found.differingOnSeam, 0);
      assert.ok(found.worst <= POSITION, `${found.worst} D`);
      assert.ok(found.worstNormal <= NORMAL, `${found.worstNormal} rad`);
      assert.deepEqual(errors, []);
    });
  }
}

for (const [seed, degree] of DEGREES.entries()) {
  test(`degrees ${degree.join(' x ')}, vertices with weights: points, normals and shared bits are right, too`, async () => {
    for (const mode of [NormalMode.FACET, NormalMode.SMOOTH, NormalMode.NONE]) {
      for (const isTorn of [false, true]) {
        const found = await page.evaluate((of) => window.comparePatches(...of), [seed, degree, mode, isTorn, true] as const);

        assert.ok(found.points > 500 && found.shared > 100, JSON.stringify(found));
        assert.equal(found.differing, 0);
        if (!isTorn) assert.equal(found.differingOnSeam, 0);
        assert.ok(found.worst <= POSITION, `${found.worst} D`);
        assert.ok(found.worstNormal <= NORMAL, `${found.worstNormal} rad`);
      }
    }
    assert.deepEqual(errors, []);
  });
}

test('a seam whose control points have moved is torn: points inside go with the lattice, those outside stay', async () => {
  const found = await page.evaluate((of) => window.comparePatches(...of), [20, [2, 2, 2], NormalMode.FACET, true] as const);

  assert.equal(found.differing, 0);
  assert.ok(found.differingOnSeam > 5, JSON.stringify(found));
  assert.ok(found.worst <= POSITION, `${found.worst} D`);
  assert.ok(found.worstNormal <= NORMAL, `${found.worstNormal} rad`);
});

test('without normals positions are the same', async () => {
  const found = await page.evaluate((of) => window.comparePatches(...of), [30, [2, 2, 2], NormalMode.NONE, false] as const);

  assert.equal(found.differing, 0);
  assert.ok(found.worst <= POSITION, `${found.worst} D`);
});

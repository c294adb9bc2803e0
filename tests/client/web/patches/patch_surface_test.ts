// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What becomes of a surface whose plan does not come.
import assert from 'node:assert/strict';
import { setTimeout as sleep } from 'node:timers/promises';
import { test } from 'node:test';
import { Code, ConnectError } from '@connectrpc/connect';
import { NormalMode } from 'latticed/v1/view_pb';
import type { Lattice } from '@src/lattice/lattice';
import { PatchSurface, type Wanted } from '@src/patches/patch_surface';
import type { SurfaceMesh } from '@src/surface/surface_mesh';

/** A surface with bounds of all edges, whose plan is refused with `reason`. */
class Refused {
  questions = 0;
  readyCalls = 0;
  readonly failures: Error[] = [];
  readonly surface: PatchSurface;

  constructor(reason: Error) {
    const mesh = { edgeBounds: { isComplete: true, layout: { id: 'a-0' }, normals: NormalMode.FACET } };
    const gl = { isContextLost: () => false };
    this.surface = new PatchSurface(gl as WebGL2RenderingContext, () => undefined, mesh as unknown as SurfaceMesh, {
      lattice: () => ({}) as Lattice,
      plan: () => {
        ++this.questions;
        return Promise.reject(reason);
      },
      ready: () => void ++this.readyCalls,
      changed: () => assert.fail('nothing was evaluated'),
      failed: (error) => void this.failures.push(error),
    });
  }

  /** Draws frames, with time for an answer after each. */
  async draw(frames: number): Promise<void> {
    for (let i = 0; i < frames; ++i) {
      this.surface.draw({} as Wanted);
      await sleep(1);
    }
  }
}

for (const code of [Code.NotFound, Code.Unavailable]) {
  test(`a plan that is refused with ${Code[code]} is asked for again after a second, not in every frame`, async () => {
    const refused = new Refused(new ConnectError('not now', code));
    await refused.draw(5);
    assert.equal(refused.questions, 1);
    await sleep(1100);
    assert.equal(refused.readyCalls, 1);
    await refused.draw(5);
    assert.equal(refused.questions, 2);
    assert.deepEqual(refused.failures, []);
    refused.surface.dispose();
  });
}

test('a plan that cannot be read is not asked for again: the surface has failed', async () => {
  const refused = new Refused(new Error('The patch plan is damaged.'));
  await refused.draw(5);
  assert.equal(refused.questions, 1);
  assert.deepEqual(refused.failures.map(({ message }) => message), ['The patch plan is damaged.']);
});

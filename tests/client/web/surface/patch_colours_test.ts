// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Data that a look needs besides points, when the server fails or does not answer at once.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { DataArrayTexture } from 'three';
import type { PatchOrigins, PatchSource, RestCorners } from '@src/surface/patch_source';
import { noPatches, SessionFixture, until } from '../support/session_fixture';

const REST: RestCorners = { origin: [0, 0, 0], corners: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0) };
const ORIGINS: PatchOrigins = { corners: Uint32Array.of(0, 1, 2), barycentrics: Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1) };

/** A pending request, which the test answers. */
interface Ask<T> {
  resolve(answer: T): void;
  reject(error: Error): void;
}

/** Patches whose requests the test answers. */
class AskedPatches implements PatchSource {
  readonly rest: Ask<RestCorners>[] = [];
  readonly uvs: Ask<PatchOrigins>[] = [];
  readonly boxOf = noPatches.boxOf;
  readonly lattice = noPatches.lattice;
  readonly restCorners = (): Promise<RestCorners> => asked(this.rest);
  readonly origins = (): Promise<PatchOrigins> => asked(this.uvs);
}

function asked<T>(asks: Ask<T>[]): Promise<T> {
  return new Promise((resolve, reject) => void asks.push({ resolve, reject }));
}

/** A session that shows one triangle at (4, 4, 4), its patches, and its failed requests. */
async function shown(t: TestContext): Promise<{ fixture: SessionFixture; patches: AskedPatches; failed: string[] }> {
  const patches = new AskedPatches();
  const fixture = await SessionFixture.live(t, { patches });
  const failed: string[] = [];
  fixture.surface.onFailed = (what, error) => failed.push(`${what}: ${(error as Error).message}`);
  fixture.sendTriangle(1n, 4);
  await until(() => fixture.surface.patchCount === 1);
  return { fixture, patches, failed };
}

test('a shape at rest that could not be had is told of once for each cause and choice, and is there when the server is', async (t) => {
  const { fixture, patches, failed } = await shown(t);
  const { surface } = fixture;

  surface.setLook({ colouring: 'displacement' });
  patches.rest[0].reject(new Error('no room'));
  await until(() => failed.length === 1);
  surface.setLook({ wireframe: true }); // the colouring is the same: nothing is asked again
  assert.equal(patches.rest.length, 1);
  await fixture.reconnect();
  patches.rest[1].reject(new Error('no room'));
  await fixture.reconnect();
  patches.rest[2].reject(new Error('no right'));
  await until(() => failed.length === 2);
  surface.setLook({ colouring: 'plain' });
  surface.setLook({ colouring: 'displacement' });
  patches.rest[3].reject(new Error('no right'));
  await until(() => failed.length === 3);
  assert.equal(surface.displacementRange, 0);
  await fixture.reconnect(); // asks again, and loses the answer with the connection
  await fixture.reconnect();
  patches.rest[5].resolve(REST);
  await until(() => surface.displacementRange > 0);
  patches.rest[4].reject(new Error('too late'));

  await fixture.reconnect();
  assert.deepEqual([failed, patches.rest.length], [['rest: no room', 'rest: no right', 'rest: no right'], 6]);
});

test('texture coordinates that could not be had are told of, and are there when the server is; another picture in the same places is drawn at once', async (t) => {
  const { fixture, patches, failed } = await shown(t);
  const { surface } = fixture;
  const setPicture = (): void => surface.setTexture(new DataArrayTexture(new Uint8Array(4), 1, 1, 1), new Float32Array(9));
  surface.setLook({ colouring: 'texture' });
  setPicture();

  patches.uvs[0].reject(new Error('no answer'));
  await until(() => failed.length === 1);
  assert.equal(surface.isTextured, false);
  await fixture.reconnect();
  patches.uvs[1].resolve(ORIGINS);
  await until(() => surface.isTextured);

  setPicture();
  assert.deepEqual([surface.isTextured, patches.uvs.length, failed], [true, 2, ['uvs: no answer']]);
});

test('the shape if only vertices moved is there when the server is; answers for other patches are dropped', async (t) => {
  const { fixture, patches, failed } = await shown(t);
  const { surface } = fixture;

  surface.setLook({ compare: 'split' });
  assert.equal(surface.isCompared, false);
  patches.uvs[0].reject(new Error('no answer'));
  patches.rest[0].resolve(REST);
  await until(() => failed.length === 1);
  await fixture.reconnect();
  patches.uvs[1].resolve(ORIGINS);
  patches.rest[1].resolve({ ...REST, corners: new Float32Array(18) }); // of two patches
  await until(() => failed.length === 2);
  surface.structureChanged();
  assert.deepEqual(failed, ['flat: no answer', 'flat: 2 patches at rest, 1 deformed']);

  fixture.sendTriangle(2n, 4);
  await until(() => patches.rest.length === 3);
  surface.structureChanged(); // the answers are of the old structure
  patches.uvs[2].resolve(ORIGINS);
  patches.rest[2].resolve(REST);
  fixture.sendTriangle(3n, 4);
  await until(() => patches.rest.length === 4);
  assert.equal(surface.isCompared, false);
  patches.uvs[3].resolve(ORIGINS);
  patches.rest[3].resolve(REST);
  await until(() => surface.isCompared);
  // The lattice is at rest: the triangle from 0 to 1 stays there, and all its points are at (4, 4, 4).
  assert.ok(Math.abs(surface.largestDifference - Math.hypot(4, 4, 4)) < 1e-6, `${surface.largestDifference}`);
});

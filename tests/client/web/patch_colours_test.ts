// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a look needs besides points, where the server does not give it at once.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { DataArrayTexture } from 'three';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import type { PatchOrigins, PatchSource, RestCorners } from '@src/surface/patch_colours';
import { noPatches, SessionFixture, until } from './support/session_fixture';

const REST: RestCorners = { origin: [0, 0, 0], corners: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0) };
const ORIGINS: PatchOrigins = { corners: Uint32Array.of(0, 1, 2), barycentrics: Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1) };

/** What has been asked, for the test to answer. */
interface Ask<T> {
  resolve(answer: T): void;
  reject(error: Error): void;
}

/** Patches whose every answer the test gives. */
class AskedPatches implements PatchSource {
  readonly rest: Ask<RestCorners>[] = [];
  readonly uvs: Ask<PatchOrigins>[] = [];
  readonly boxOf = noPatches.boxOf;

  restCorners(): Promise<RestCorners> {
    return asked(this.rest);
  }

  origins(): Promise<PatchOrigins> {
    return asked(this.uvs);
  }
}

function asked<T>(asks: Ask<T>[]): Promise<T> {
  return new Promise((resolve, reject) => void asks.push({ resolve, reject }));
}

/** A session that shows one triangle at (4, 4, 4), and what it failed to get. */
async function shown(context: TestContext): Promise<{ fixture: SessionFixture; patches: AskedPatches; failed: string[] }> {
  const patches = new AskedPatches();
  const fixture = await SessionFixture.live({ patches });
  context.after(() => fixture.session.close());
  const failed: string[] = [];
  fixture.surface.onFailed = (what, error) => failed.push(`${what}: ${(error as Error).message}`);
  const { stream } = fixture;
  stream.event({ case: 'topology', value: {
    topologyId: 't', patchCount: 1n, pointCount: 3n, triangleCount: 1n, segments: 1, chunkRuns: [{ chunkCount: 1, patchesPerChunk: 1 }],
    pattern: { points: [1, 0, 0, 0, 1, 0, 0, 0, 1], triangles: [0, 1, 2] } } });
  stream.event({ case: 'quantisation', value: { quantisationId: 1n, origin: {}, step: 1, bits: 12 } });
  stream.event({ case: 'updateBegin', value: { updateId: 1n, revision: 1n, view: { encoding: Encoding.QUANTISED, normals: NormalMode.NONE } } });
  const data = new Uint8Array(new Uint16Array(9).fill(4).buffer);
  stream.event({ case: 'chunks', value: { updateId: 1n, topologyId: 't', quantisationId: 1n, chunks: [{ index: 0, data }] } });
  stream.event({ case: 'updateEnd', value: { updateId: 1n, revision: 1n } });
  await until(() => fixture.surface.patchCount === 1);
  return { fixture, patches, failed };
}

/** Loses the stream, and opens the next. */
async function reconnect(fixture: SessionFixture): Promise<void> {
  const { length } = fixture.sockets.opened;
  fixture.stream.end();
  await until(() => fixture.sockets.opened.length > length);
  fixture.stream.hello();
}

test('a shape at rest that could not be had is told of once for each cause, and is there when the server is', async (context) => {
  const { fixture, patches, failed } = await shown(context);

  fixture.surface.setLook({ colouring: 'displacement' });
  patches.rest[0].reject(new Error('no room'));
  await until(() => failed.length === 1);
  fixture.surface.setLook({ wireframe: true }); // nothing else was chosen
  assert.equal(patches.rest.length, 1);
  await reconnect(fixture);
  assert.equal(patches.rest.length, 2);
  patches.rest[1].reject(new Error('no room'));
  await reconnect(fixture);
  patches.rest[2].reject(new Error('no right'));
  await until(() => failed.length === 2);
  assert.equal(fixture.surface.displacementRange, 0);
  await reconnect(fixture);
  patches.rest[3].resolve(REST);
  await until(() => fixture.surface.displacementRange > 0);

  assert.deepEqual(failed, ['rest: no room', 'rest: no right']);
  await reconnect(fixture);
  assert.equal(patches.rest.length, 4); // it is here
});

test('who chooses a look again is told again; an answer that was lost with the connection is not waited for', async (context) => {
  const { fixture, patches, failed } = await shown(context);
  fixture.surface.setLook({ ghost: true });
  patches.rest[0].reject(new Error('no room'));
  await until(() => failed.length === 1);

  fixture.surface.setLook({ ghost: false });
  assert.equal(patches.rest.length, 1);
  fixture.surface.setLook({ ghost: true });
  patches.rest[1].reject(new Error('no room'));
  await until(() => failed.length === 2);
  fixture.surface.setLook({ colouring: 'displacement' });
  await reconnect(fixture);
  patches.rest[3].resolve(REST);
  await until(() => fixture.surface.displacementRange > 0);
  patches.rest[2].reject(new Error('too late'));
  await reconnect(fixture);

  assert.deepEqual([failed, patches.rest.length], [['rest: no room', 'rest: no room'], 4]);
});

test('texture coordinates that could not be had are told of, and are there when the server is', async (context) => {
  const { fixture, patches, failed } = await shown(context);
  fixture.surface.setLook({ colouring: 'texture' });
  fixture.surface.setTexture(new DataArrayTexture(new Uint8Array(4), 1, 1, 1), new Float32Array(9));

  patches.uvs[0].reject(new Error('no answer'));
  await until(() => failed.length === 1);
  assert.equal(fixture.surface.isTextured, false);
  await reconnect(fixture);
  patches.uvs[1].resolve(ORIGINS);
  await until(() => fixture.surface.isTextured);

  assert.deepEqual(failed, ['uvs: no answer']);
});

test('another picture in the same places is drawn at once, in others when their coordinates are here', async (context) => {
  const { fixture: { surface }, patches } = await shown(context);
  const picture = (): DataArrayTexture => new DataArrayTexture(new Uint8Array(4), 1, 1, 1);
  surface.setLook({ colouring: 'texture' });
  surface.setTexture(picture(), new Float32Array(9));
  patches.uvs[0].resolve(ORIGINS);
  await until(() => surface.isTextured);

  surface.setTexture(picture(), new Float32Array(9));
  assert.deepEqual([surface.isTextured, patches.uvs.length], [true, 1]);
  surface.setTexture(picture(), new Float32Array(9).fill(1));
  assert.deepEqual([surface.isTextured, patches.uvs.length], [false, 2]);
  patches.uvs[1].resolve(ORIGINS);
  await until(() => surface.isTextured);
});

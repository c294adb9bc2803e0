// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import { Services } from '@src/intake/services';
import { SceneKeeper } from '@src/session/store/scene_keeper';
import { FakeServer } from './support/fake_server';
import { MemorySceneStore } from './support/memory_scene_store';
import { cubeLattice, until } from './support/session_fixture';

/** A server whose downloads wait until release() is called. */
class HeldServer extends FakeServer {
  release!: () => void;

  constructor() {
    super();
    this.meshes.set('mesh-1', Uint8Array.of(1, 2, 3));
    this.meshFacts = { format: MeshFormat.GLB, hasUvs: true };
    this.hold = new Promise((resolve) => (this.release = resolve));
  }
}

async function bytesOf(content: Blob | undefined): Promise<number[]> {
  return [...new Uint8Array(await content!.arrayBuffer())];
}

test('a mesh is fetched once for its pictures, for its texture and to be kept, where that is at the same time', async () => {
  const server = new HeldServer();
  const store = new MemorySceneStore();
  const services = new Services(server.client);
  const keeper = new SceneKeeper(server.client, store, 'scene-0001');

  const kept = keeper.keep(cubeLattice());
  const pictured = services.picturedMesh('mesh-1', keeper).then((mesh) => mesh?.file);
  const files = [pictured, services.downloadMesh('mesh-1', keeper)];
  await until(() => server.downloads === 1);
  server.release();

  for (const file of await Promise.all(files)) assert.deepEqual(await bytesOf(file?.content), [1, 2, 3]);
  await kept;
  assert.deepEqual(await bytesOf((await store.mesh('mesh-1'))?.content), [1, 2, 3]);
  assert.equal(server.downloads, 1);
  assert.deepEqual(await bytesOf((await services.downloadMesh('mesh-1', keeper)).content), [1, 2, 3]);
  assert.equal(server.downloads, 2); // a page does not keep the file in memory
});

test('a scene that is left ends the download of its mesh, and says nothing of it', async () => {
  const server = new HeldServer();
  const keeper = new SceneKeeper(server.client, new MemorySceneStore(), 'scene-0001');
  const said: string[] = [];
  keeper.onNotKept = (text) => said.push(text);
  const kept = keeper.keep(cubeLattice());
  await until(() => server.downloads === 1);

  keeper.close();
  await kept;
  await until(() => server.abandoned === 1);

  assert.deepEqual(said, []);
});

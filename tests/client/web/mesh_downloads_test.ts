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

/** One whose download waits until it is released, and which counts who asks the page for one. */
class HeldServer extends FakeServer {
  asked = 0;
  release!: () => void;

  constructor() {
    super();
    this.meshes.set('mesh-1', Uint8Array.of(1, 2, 3));
    this.meshFacts = { format: MeshFormat.GLB, hasUvs: true };
    this.hold = new Promise((resolve) => (this.release = resolve));
    const { downloads } = this.client;
    const get = downloads.get.bind(downloads);
    downloads.get = (...mesh) => (++this.asked, get(...mesh));
  }
}

async function bytesOf(content: Blob | undefined): Promise<number[]> {
  return [...new Uint8Array(await content!.arrayBuffer())];
}

test('a mesh is fetched once for its pictures, for its texture and to be kept, where that is at the same time', async () => {
  const server = new HeldServer();
  const store = new MemorySceneStore();
  const services = new Services(server.client);
  const { signal } = new AbortController();

  const kept = new SceneKeeper(server.client, store, 'scene-0001').keep(cubeLattice());
  const pictured = services.picturedMesh('mesh-1', signal).then((mesh) => mesh?.file);
  const files = [pictured, services.downloadMesh('mesh-1', signal)];
  await until(() => server.asked === 3);
  server.release();

  for (const file of await Promise.all(files)) assert.deepEqual(await bytesOf(file?.content), [1, 2, 3]);
  await kept;
  assert.deepEqual(await bytesOf((await store.mesh('mesh-1'))?.content), [1, 2, 3]);
  assert.equal(server.downloads, 1);
  assert.deepEqual(await bytesOf((await services.downloadMesh('mesh-1', signal)).content), [1, 2, 3]);
  assert.equal(server.downloads, 2); // no page has one in memory for ever
});

test('a download goes on for who waits for it still, and ends when nobody does; who comes then begins anew', async () => {
  const server = new HeldServer();
  const { downloads } = server.client;
  const [first, second] = [new AbortController(), new AbortController()];
  const [one, two] = [downloads.get('mesh-1', first.signal), downloads.get('mesh-1', second.signal)];
  await until(() => server.downloads === 1);

  first.abort();
  await assert.rejects(one, { name: 'AbortError' });
  assert.equal(server.abandoned, 0);
  second.abort();
  await assert.rejects(two, { name: 'AbortError' });
  const three = downloads.get('mesh-1');
  await until(() => server.abandoned === 1);
  server.release();

  assert.deepEqual(await bytesOf((await three).content), [1, 2, 3]);
  assert.equal(server.downloads, 2);
  await assert.rejects(downloads.get('mesh-1', first.signal), { name: 'AbortError' });
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

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import { Services } from '@src/intake/services';
import { MeshDownloads } from '@src/wire/mesh_downloads';
import { FakeServer } from '../support/fake_server';
import { until } from '../support/session_fixture';

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

test('a mesh is fetched once for its pictures and for its texture, where that is at the same time', async () => {
  const server = new HeldServer();
  const services = new Services(server.client);
  const downloads = new MeshDownloads(server.client.meshes);

  const pictured = services.picturedMesh('mesh-1', downloads).then((mesh) => mesh?.file);
  const files = [pictured, services.downloadMesh('mesh-1', downloads)];
  await until(() => server.downloads === 1);
  server.release();

  for (const file of await Promise.all(files)) assert.deepEqual(await bytesOf(file?.content), [1, 2, 3]);
  assert.equal(server.downloads, 1);
  assert.deepEqual(await bytesOf((await services.downloadMesh('mesh-1', downloads)).content), [1, 2, 3]);
  assert.equal(server.downloads, 2); // a page does not keep the file in memory
});

test('a scene that is left ends the download of its mesh', async () => {
  const server = new HeldServer();
  const downloads = new MeshDownloads(server.client.meshes);
  const file = downloads.downloadMesh('mesh-1');
  await until(() => server.downloads === 1);

  downloads.close();

  await assert.rejects(file);
  await until(() => server.abandoned === 1);
});

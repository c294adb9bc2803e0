// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import { Code } from '@connectrpc/connect';
import { LatticeSourceSchema, type LatticeSource } from 'latticed/v1/lattice_pb';
import { MeshHeaderSchema } from 'latticed/v1/mesh_pb';
import { CreateSceneRequestSchema, type CreateSceneRequest, type Scene } from 'latticed/v1/scene_pb';
import type { Lattice } from '../lattice/lattice';
import { downloadMesh } from '../wire/download';
import { fromLattice } from '../wire/lattice_message';
import type { LatticedServer } from '../wire/latticed_server';
import { ServerError } from '../wire/server_error';
import { uploadMesh } from '../wire/upload';
import type { SceneStore } from './scene_store';

/**
 * Keeps what it takes to make a scene again in a server that has lost it: the mesh's bytes, the request that made
 * it, and the newest lattice.
 */
export class SceneKeeper {
  private static readonly LARGEST_DOWNLOAD = 256n << 20n;  // larger meshes are kept only where they were uploaded
  private static readonly SAVE_AFTER_MS = 500;

  private request: CreateSceneRequest | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private bootId = '';

  constructor(
    private readonly server: LatticedServer,
    private readonly store: SceneStore,
    private readonly sceneId: string,
  ) {}

  /** The run of the server that has the scene. */
  runsOn(bootId: string): void {
    this.bootId = bootId;
  }

  /** Remembers a scene, and fetches its mesh if the store lacks it. */
  async keep(scene: Scene, lattice: Lattice): Promise<void> {
    this.request = create(CreateSceneRequestSchema, {
      sceneId: scene.id, mesh: scene.mesh, labels: scene.labels,
      ...(scene.defaultView && { defaultView: scene.defaultView }), ...(scene.idleTtl && { idleTtl: scene.idleTtl }),
    });
    await this.save(lattice);
    if (await this.store.mesh(scene.mesh)) return;
    const { totalBytes } = await this.server.meshes.getMesh({ mesh: scene.mesh });
    if (totalBytes > SceneKeeper.LARGEST_DOWNLOAD) return;
    const { header, bytes } = await downloadMesh(this.server, scene.mesh);
    await this.store.saveMesh({ id: scene.mesh, header: toBinary(MeshHeaderSchema, header), bytes });
  }

  /** The lattice has changed; it is saved when it rests. */
  changed(lattice: () => Lattice): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.save(lattice()).catch(() => undefined), SceneKeeper.SAVE_AFTER_MS);
  }

  /**
   * Makes the scene again, with `lattice` or the newest that was saved. False where the same run of the server that
   * had it says that it is gone, so that somebody deleted it, or where nothing was saved. Rejects with a ServerError.
   */
  async restore(lattice?: Lattice): Promise<boolean> {
    const stored = await this.store.scene(this.sceneId);
    if (!stored) return false;
    try {
      const { bootId } = await this.server.server.getServerInfo({});
      if (bootId === stored.bootId) return false;
      const request = fromBinary(CreateSceneRequestSchema, stored.request);
      if (lattice) request.lattices = [sourceOf(lattice)];
      await this.uploadAgain(request.mesh);
      await this.createUnlessThere(request);
      await this.store.saveScene({ ...stored, bootId, request: toBinary(CreateSceneRequestSchema, request) });
      return true;
    } catch (error) {
      throw ServerError.fromConnect(error);
    }
  }

  close(): void {
    clearTimeout(this.timer);
  }

  private async createUnlessThere(request: CreateSceneRequest): Promise<void> {
    try {
      await this.server.scenes.createScene(request);
    } catch (error) {  // another window may have been quicker
      if (ServerError.fromConnect(error).code !== Code.AlreadyExists) throw error;
    }
  }

  private async uploadAgain(id: string): Promise<void> {
    try {
      await this.server.meshes.getMesh({ mesh: id });
      return;
    } catch (error) {
      if (ServerError.fromConnect(error).code !== Code.NotFound) throw error;
    }
    const mesh = await this.store.mesh(id);
    if (!mesh) throw new ServerError(Code.NotFound, 'NOT_FOUND', 'the server was restarted and this browser has no copy of the mesh');
    await uploadMesh(this.server, fromBinary(MeshHeaderSchema, mesh.header), mesh.bytes);
  }

  private async save(lattice: Lattice): Promise<void> {
    if (!this.request) return;
    const request = { ...this.request, lattices: [sourceOf(lattice)] };
    await this.store.saveScene({
      id: this.sceneId, mesh: request.mesh, bootId: this.bootId, savedAt: Date.now(),
      request: toBinary(CreateSceneRequestSchema, request) });
  }
}

function sourceOf(lattice: Lattice): LatticeSource {
  return create(LatticeSourceSchema, { source: { case: 'lattice', value: fromLattice(lattice) } });
}

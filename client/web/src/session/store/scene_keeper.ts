// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { LatticeSourceSchema, type LatticeSource } from 'latticed/v1/lattice_pb';
import { MeshHeaderSchema } from 'latticed/v1/mesh_pb';
import { CreateSceneRequestSchema, type CreateSceneRequest } from 'latticed/v1/scene_pb';
import type { Lattice } from '../../lattice/lattice';
import { LONG_CALL_MS } from '../../wire/deadlines';
import { fromLattice } from '../../wire/lattice_message';
import type { LatticedServer } from '../../wire/latticed_server';
import { ServerError } from '../../wire/server_error';
import { downloadMesh, type DownloadedMesh } from '../../wire/mesh_download';
import { uploadMesh } from '../../wire/upload';
import { bytes, inWords } from '../../wire/words';
import type { SceneStore } from './indexed_scene_store';
import { storedMesh, type StoredMesh } from './scene_store';

/** A scene that was made again. */
export interface Restored {
  readonly by: 'here' | 'elsewhere';
  /** The run of the server that has the scene. */
  readonly bootId: string;
}

/**
 * Keeps what is needed to make a scene again in a server that has lost it: the mesh's bytes, the request that made the
 * scene, and the newest lattice.
 */
export class SceneKeeper {
  private static readonly LARGEST_READ_BACK = 256n << 20n;  // larger meshes are kept only where they were uploaded
  private static readonly SAVE_AFTER_MS = 500;

  private request: CreateSceneRequest | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private bootId = '';
  private kept: Promise<void> | undefined;
  private download: Promise<DownloadedMesh> | undefined;
  private readonly closed = new AbortController();
  /** Called once, in words, if the scene would be lost with the server, or with the server and this page. */
  onNotKept: ((text: string) => void) | undefined;

  constructor(
    private readonly server: LatticedServer,
    private readonly store: SceneStore,
    private readonly sceneId: string,
  ) {}

  /** The run of the server that has the scene. */
  runsOn(bootId: string): void {
    this.bootId = bootId;
  }

  /**
   * Saves the scene and its mesh, which is fetched from the server if the store lacks it. To be called after every
   * connect: it repeats what failed because the connection before was lost, and does all else once.
   */
  keep(lattice: Lattice): Promise<void> {
    return (this.kept ??= this.keepAll(lattice).catch((error: unknown) => {
      if (error instanceof ConnectError && ServerError.fromConnect(error).isPassing) this.kept = undefined;
      else this.warn(error);
    }));
  }

  /** Saves the lattice once it has not changed for half a second. */
  changed(lattice: () => Lattice): void {
    clearTimeout(this.timer);
    const save = (): Promise<void> => this.save(lattice()).catch((error: unknown) => this.warn(error));
    this.timer = setTimeout(() => void save(), SceneKeeper.SAVE_AFTER_MS);
  }

  /**
   * Makes the scene again with `lattice`, or with the newest saved lattice, and returns who did: another window may
   * have been quicker. Undefined if nothing was saved, or if the server is the same run as before: somebody deleted the
   * scene. Rejects with a ServerError if a call failed, or with an error of the page itself.
   */
  async restore(lattice?: Lattice): Promise<Restored | undefined> {
    try {
      const stored = await this.store.scene(this.sceneId);
      if (!stored) return undefined;
      const { bootId } = await this.server.server.getServerInfo({});
      // Another window saves the new run with the scene that it has made.
      if (bootId === stored.bootId) return (await succeeds(this.server.scenes.getScene({ scene: this.sceneId }), Code.NotFound)) ? { by: 'elsewhere', bootId } : undefined;
      const request = fromBinary(CreateSceneRequestSchema, stored.request);
      if (lattice) request.lattices = [sourceOf(lattice)];
      await this.uploadAgain(request.mesh);
      if (!(await succeeds(this.server.scenes.createScene(request, { timeoutMs: LONG_CALL_MS }), Code.AlreadyExists))) return { by: 'elsewhere', bootId };
      const restored = { ...stored, bootId, request: toBinary(CreateSceneRequestSchema, request) };
      await this.store.saveScene(restored).catch((error: unknown) => this.warn(error));
      return { by: 'here', bootId };
    } catch (error) {
      throw error instanceof ConnectError ? ServerError.fromConnect(error) : error;
    }
  }

  /** The scene's mesh as it was uploaded. Concurrent callers share one download. Rejects after close(). */
  downloadMesh(id: string): Promise<DownloadedMesh> {
    return (this.download ??= downloadMesh(this.server.meshes, id, this.closed.signal).finally(() => (this.download = undefined)));
  }

  close(): void {
    this.closed.abort();
    clearTimeout(this.timer);
    this.onNotKept = undefined;
  }

  private async keepAll(lattice: Lattice): Promise<void> {
    const scene = await this.server.scenes.getScene({ scene: this.sceneId });
    this.request = create(CreateSceneRequestSchema, {
      sceneId: scene.id, mesh: scene.mesh, labels: scene.labels,
      defaultView: scene.defaultView, idleTtl: scene.idleTtl, units: scene.units, name: scene.name,
      ...(scene.creaseAngle !== undefined && { creaseAngle: scene.creaseAngle }),
    });
    // If one is refused, the other must still be saved.
    const saved = await Promise.allSettled([this.save(lattice), this.keepMesh(scene.mesh)]);
    for (const result of saved) if (result.status === 'rejected') throw result.reason;
    await this.store.forgetOld();
  }

  private async keepMesh(id: string): Promise<void> {
    if (await this.store.keepsMesh(id)) return;
    await this.store.saveMesh((await this.store.mesh(id)) ?? (await this.readBack(id)));
  }

  private async readBack(id: string): Promise<StoredMesh> {
    const { totalBytes } = await this.server.meshes.getMesh({ mesh: id });
    if (totalBytes > SceneKeeper.LARGEST_READ_BACK) {
      throw new Error(`its mesh, ${bytes(Number(totalBytes))}, was uploaded elsewhere and is too large to fetch`);
    }
    const { header, content } = await this.downloadMesh(id);
    return storedMesh(id, header, content);
  }

  private warn(error: unknown): void {
    this.onNotKept?.(`If the server is restarted, this scene may be lost: ${inWords(error)}`);
    this.onNotKept = undefined;
  }

  private async uploadAgain(id: string): Promise<void> {
    if (await succeeds(this.server.meshes.getMesh({ mesh: id }), Code.NotFound)) return;
    const mesh = await this.store.mesh(id);
    if (!mesh) throw new ServerError(Code.NotFound, 'NOT_FOUND', 'the server was restarted and this browser has no copy of the mesh');
    await uploadMesh(this.server, fromBinary(MeshHeaderSchema, mesh.header), mesh.content);
  }

  private async save(lattice: Lattice): Promise<void> {
    if (!this.request) return;
    const request = { ...this.request, lattices: [sourceOf(lattice)] };
    await this.store.saveScene({
      id: this.sceneId, mesh: request.mesh, bootId: this.bootId, savedAt: Date.now(),
      request: toBinary(CreateSceneRequestSchema, request) });
  }
}

/** Whether a call succeeds; false if it fails with `expected`. Rejects with any other failure. */
async function succeeds(call: Promise<unknown>, expected: Code): Promise<boolean> {
  try {
    await call;
    return true;
  } catch (error) {
    if (ServerError.fromConnect(error).code !== expected) throw error;
    return false;
  }
}

function sourceOf(lattice: Lattice): LatticeSource {
  return create(LatticeSourceSchema, { source: { case: 'lattice', value: fromLattice(lattice) } });
}

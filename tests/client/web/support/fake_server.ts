// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { MeshSchema, MeshService, type DownloadMeshResponseSchema } from 'latticed/v1/mesh_pb';
import { SceneSchema, SceneService, type CreateSceneRequest } from 'latticed/v1/scene_pb';
import { ServerInfoSchema, ServerService, type Feature, type ServerInfo } from 'latticed/v1/server_pb';
import { LatticedServer } from '@src/wire/latticed_server';

/** Answers a session's calls, other than its stream, from memory. */
export class FakeServer {
  bootId = 'boot-1';
  /** The error of GetServerInfo, if it is to fail. */
  refusal: ConnectError | undefined;
  features: Feature[] = [];
  /** Whether GetScene fails with NOT_FOUND. */
  deleted = false;
  readonly meshes = new Map<string, Uint8Array>();
  readonly scenes = new Map<string, CreateSceneRequest>();
  /** The size that GetMesh states in place of the real one. */
  meshBytes: bigint | undefined;
  /** The number of DownloadMesh calls. */
  downloads = 0;
  downloadRefusal: ConnectError | undefined;
  /** More fields of GetMesh's answer. */
  meshFacts: MessageInitShape<typeof MeshSchema> = {};
  /** More fields of GetScene's answer. */
  sceneFacts: MessageInitShape<typeof SceneSchema> = {};
  /** Downloads wait for this. */
  hold: Promise<void> | undefined;
  /** The number of downloads that the page ended while they waited. */
  abandoned = 0;
  /** The deadlines of GetServerInfo and Pick calls that have one, in ms, the newest last. */
  readonly deadlines: number[] = [];
  private uploaded: number[] = [];

  readonly client = new LatticedServer('http://test', undefined, createRouterTransport(({ service }) => {
    service(ServerService, { getServerInfo: (_, { timeoutMs }) => (this.note(timeoutMs()), this.info()) });
    service(MeshService, {
      getMesh: ({ mesh }) =>
        create(MeshSchema, { id: mesh, totalBytes: this.meshBytes ?? BigInt(this.mesh(mesh).length), ...this.meshFacts }),
      beginUpload: () => ((this.uploaded = []), { uploadId: 'u' }),
      appendUpload: ({ data }) => (this.uploaded.push(...data), { committed: BigInt(this.uploaded.length) }),
      finishUpload: () => (this.meshes.set('mesh-1', Uint8Array.from(this.uploaded)), create(MeshSchema, { id: 'mesh-1' })),
      downloadMesh: ({ mesh }, { signal }) => this.download(mesh, signal),
    });
    service(SceneService, {
      getScene: ({ scene }) => {
        if (this.deleted) throw new ConnectError('no such scene', Code.NotFound);
        return create(SceneSchema, { id: scene, mesh: this.scenes.get(scene)?.mesh ?? 'mesh-1', ...this.sceneFacts });
      },
      pick: (_, { timeoutMs }) => {
        this.note(timeoutMs());
        throw new ConnectError('aborted', Code.DeadlineExceeded);
      },
      createScene: (request) => {
        this.mesh(request.mesh);
        this.scenes.set(request.sceneId, request);
        return create(SceneSchema, { id: request.sceneId, mesh: request.mesh });
      },
    });
  }));

  info(): ServerInfo {
    if (this.refusal) throw this.refusal;
    return create(ServerInfoSchema, { bootId: this.bootId, features: this.features, limits: { maxPresenceName: 8 } });
  }

  async *download(mesh: string, signal: AbortSignal): AsyncGenerator<MessageInitShape<typeof DownloadMeshResponseSchema>> {
    ++this.downloads;
    if (this.downloadRefusal) throw this.downloadRefusal;
    const bytes = this.mesh(mesh);
    const abandon = (): number => ++this.abandoned;
    signal.addEventListener('abort', abandon);
    await this.hold;
    signal.removeEventListener('abort', abandon);
    const { format } = this.meshFacts;
    yield { message: { case: 'header', value: { name: 'cube', totalBytes: BigInt(bytes.length), ...(format && { format }) } } };
    yield { message: { case: 'data', value: bytes as Uint8Array<ArrayBuffer> } };
  }

  mesh(id: string): Uint8Array {
    const bytes = this.meshes.get(id);
    if (!bytes) throw new ConnectError('no such mesh', Code.NotFound);
    return bytes;
  }

  private note(deadline: number | undefined): void {
    if (deadline !== undefined) this.deadlines.push(deadline);
  }
}

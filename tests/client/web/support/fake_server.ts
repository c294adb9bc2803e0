// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { MeshSchema, MeshService, type DownloadMeshResponseSchema } from 'latticed/v1/mesh_pb';
import type { PatchPlanPart } from 'latticed/v1/patches_pb';
import { SceneService } from 'latticed/v1/scene_pb';
import { ServerInfoSchema, ServerService, type Feature, type ServerInfo } from 'latticed/v1/server_pb';
import { Encoding } from 'latticed/v1/view_pb';
import { LatticedServer } from '@src/wire/latticed_server';

/** Answers a session's calls, other than its stream, from memory. */
export class FakeServer {
  durable = true;
  /** The error of GetServerInfo, if it is to fail. */
  refusal: ConnectError | undefined;
  features: Feature[] = [];
  encodings: Encoding[] = [Encoding.DRACO_POINTS, Encoding.MESHOPT];
  /** Milliseconds that a byte of GetServerInfo's probes takes, and the bytes that were asked for. */
  msPerProbeByte = 0;
  readonly probes: number[] = [];
  readonly meshes = new Map<string, Uint8Array>();
  /** By topology id. */
  readonly plans = new Map<string, readonly PatchPlanPart[]>();
  /** The number of DownloadMesh calls. */
  downloads = 0;
  /** More fields of GetMesh's answer. */
  meshFacts: MessageInitShape<typeof MeshSchema> = {};
  /** Downloads wait for this. */
  hold: Promise<void> | undefined;
  /** The number of downloads that the page ended while they waited. */
  abandoned = 0;
  /** The deadlines of GetServerInfo and Pick calls that have one, in ms, the newest last. */
  readonly deadlines: number[] = [];

  readonly client = new LatticedServer('http://test', undefined, createRouterTransport(({ service }) => {
    const { plans } = this;
    service(ServerService, {
      getServerInfo: async ({ probeBytes }, { timeoutMs }) => {
        this.note(timeoutMs());
        this.probes.push(probeBytes);
        if (this.msPerProbeByte > 0) await new Promise((resolve) => setTimeout(resolve, probeBytes * this.msPerProbeByte));
        return this.info();
      },
    });
    service(MeshService, {
      getMesh: ({ mesh }) =>
        create(MeshSchema, { id: mesh, totalBytes: BigInt(this.mesh(mesh).length), ...this.meshFacts }),
      downloadMesh: ({ mesh }, { signal }) => this.download(mesh, signal),
    });
    service(SceneService, {
      getPatchPlan: async function* (this: void, { topologyId }) {
        yield* plans.get(topologyId) ?? [];
      },
      pick: (_, { timeoutMs }) => {
        this.note(timeoutMs());
        throw new ConnectError('aborted', Code.DeadlineExceeded);
      },
    });
  }));

  info(): ServerInfo {
    if (this.refusal) throw this.refusal;
    const { durable, features, encodings } = this;
    return create(ServerInfoSchema, { durable, features, encodings, limits: { maxPresenceName: 8 } });
  }

  async *download(mesh: string, signal: AbortSignal): AsyncGenerator<MessageInitShape<typeof DownloadMeshResponseSchema>> {
    ++this.downloads;
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

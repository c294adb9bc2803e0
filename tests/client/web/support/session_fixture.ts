// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { TestContext } from 'node:test';
import { Code } from '@connectrpc/connect';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import type { DecodePool } from '@src/decode/decode_pool';
import { Lattice } from '@src/lattice/lattice';
import { LiveSession } from '@src/session/live_session';
import type { BackOff, Wakeable } from '@src/session/scene_connection';
import type { PatchSource } from '@src/surface/patch_source';
import { SurfaceMesh } from '@src/surface/surface_mesh';
import { fromLattice } from '@src/wire/lattice_message';
import { MeshDownloads } from '@src/wire/mesh_downloads';
import { ServerError } from '@src/wire/server_error';
import { FakeServer } from './fake_server';
import { FakeStreams, type FakeStream } from './fake_stream';
import { FakeWorker, poolOf } from './fake_worker';
import { fitLattice } from '@src/lattice/fitted_lattice';
import { until } from './until';

export { until };


/** Patches for tests that never ask for their origins or rest shape. */
export const noPatches: PatchSource = {
  origins: () => Promise.reject(new Error('not asked for')),
  restCorners: () => Promise.reject(new Error('not asked for')),
  boxOf: () => 0,
  lattice: () => fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [3, 3, 3], degree: [2, 2, 2], padding: 0 }),
};

export interface Options {
  readonly server?: FakeServer;
  readonly features?: FakeServer['features'];
  readonly durable?: boolean;
  readonly backOff?: BackOff;
  readonly patches?: PatchSource;
  /** Whether the worker decodes each chunk at once. Default: true. */
  readonly decodesAtOnce?: boolean;
}

/** The errors that end a stream: the connection is lost, or the server has no such scene. */
export const unavailable = new ServerError(Code.Unavailable, '', 'the connection is lost');
export const noScene = new ServerError(Code.NotFound, 'NOT_FOUND', 'no scene scene-0001');

/** A session whose server is the test. It ends with the test. Its lattice has 3 x 3 x 3 points over the unit cube. */
export class SessionFixture {
  readonly server: FakeServer;
  readonly sockets = new FakeStreams();
  readonly watches = new FakeStreams();
  readonly worker: FakeWorker;
  readonly pool: DecodePool;
  readonly surface: SurfaceMesh;
  readonly said: string[] = [];
  readonly session: LiveSession;
  /** The connection that the page wakes; undefined once the session is closed. */
  awake: Wakeable | undefined;

  constructor(t: TestContext, options: Options = {}) {
    this.surface = new SurfaceMesh(options.patches ?? noPatches);
    this.worker = new FakeWorker(options.decodesAtOnce ?? true);
    this.pool = poolOf(this.worker);
    this.server = options.server ?? new FakeServer();
    this.server.features = options.features ?? [];
    this.server.durable = options.durable ?? true;
    this.session = new LiveSession('scene-0001', {
      server: this.server.client, info: this.server.info(), streams: [this.sockets.open, this.watches.open],
      pool: this.pool, surface: this.surface,
      downloads: new MeshDownloads(this.server.client.meshes),
      backOff: options.backOff ?? { firstMs: 1, lastMs: 2 },
      wakes: (connection) => {
        this.awake = connection;
        return () => (this.awake = undefined);
      },
    });
    this.session.on('refused', (text) => this.said.push(text));
    this.session.ready.catch(() => undefined);
    t.after(() => this.session.close());
  }

  /** A connected session that has its first lattice. */
  static async live(t: TestContext, options: Options = {}): Promise<SessionFixture> {
    const fixture = new SessionFixture(t, options);
    fixture.stream.hello();
    fixture.state();
    await fixture.session.ready;
    return fixture;
  }

  get stream(): FakeStream {
    return this.sockets.newest;
  }

  /** Ends the stream, and waits until the session opens the next one. */
  async lose(error?: ServerError): Promise<void> {
    const { length } = this.sockets.opened;
    this.stream.end(error);
    await until(() => this.sockets.opened.length > length);
  }

  /** Like lose(); the next stream then says hello. */
  async reconnect(error?: ServerError): Promise<void> {
    await this.lose(error);
    this.stream.hello();
  }

  state(lattice = cubeLattice(), structureId = 1n, revision = 0n): void {
    this.stream.event({ case: 'latticeState', value: { lattice: fromLattice(lattice), structureId, revision } });
  }

  delta(revision: bigint, indices: number[], positions: number[], editorId = this.session.editorId): void {
    this.stream.event({ case: 'latticeDelta', value: { structureId: 1n, revision, indices, positions, editorId } });
  }

  accept(sequence: bigint, revision: bigint): void {
    this.stream.event({ case: 'editResult', value: { sequence, revision, structureId: 1n } });
  }

  /** Sends a complete update of one triangle whose points are all at (value, value, value). */
  sendTriangle(updateId: bigint, value = 0): void {
    const { stream } = this;
    stream.event({ case: 'topology', value: {
      topologyId: 't', patchCount: 1n, pointCount: 3n, triangleCount: 1n, segments: 1, chunkRuns: [{ chunkCount: 1, patchesPerChunk: 1 }],
      pattern: { points: [1, 0, 0, 0, 1, 0, 0, 0, 1], triangles: [0, 1, 2] } } });
    stream.event({ case: 'quantisation', value: { quantisationId: 1n, origin: { x: 0, y: 0, z: 0 }, step: 1, bits: 12 } });
    stream.event({ case: 'updateBegin', value: { updateId, view: { encoding: Encoding.QUANTISED, normals: NormalMode.NONE } } });
    const data = new Uint8Array(new Uint16Array(9).fill(value).buffer);
    stream.event({ case: 'chunks', value: { updateId, topologyId: 't', quantisationId: 1n, chunks: [{ index: 0, data }] } });
    stream.event({ case: 'updateEnd', value: { updateId, resumeToken: Uint8Array.of(Number(updateId)) } });
  }

  /** The x of a control point that the page shows. */
  x(index: number): number {
    return this.session.lattice.points[3 * index]!;
  }
}

/** A lattice with points at 0, 1/2 and 1 along each axis. Point 0 is at the origin, point 1 at (0.5, 0, 0). */
export function cubeLattice(): Lattice {
  return fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [3, 3, 3], degree: [2, 2, 2], padding: 0 });
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { readFileSync } from 'node:fs';
import { DecodePool } from '@src/decode/decode_pool';
import { Lattice } from '@src/lattice/lattice';
import { LiveSession } from '@src/session/live_session';
import type { BackOff, Wakeable } from '@src/session/scene_connection';
import { SceneKeeper } from '@src/session/store/scene_keeper';
import type { PatchSource } from '@src/surface/patch_colours';
import { SurfaceMesh } from '@src/surface/surface_mesh';
import { fromLattice } from '@src/wire/lattice_message';
import { FakeServer } from './fake_server';
import { FakeStreams, type FakeStream } from './fake_stream';
import { FakeWorker } from './fake_worker';
import { MemorySceneStore } from './memory_scene_store';
import { fitLattice } from './fitted_lattice';

export const decoderWasm = new Uint8Array(readFileSync('node_modules/draco3d/draco_decoder.wasm')).buffer;

/** Patches that nobody asks for. */
export const noPatches: PatchSource = {
  origins: () => Promise.reject(new Error('not asked for')),
  restCorners: () => Promise.reject(new Error('not asked for')),
  boxOf: () => 0,
};

export interface Options {
  readonly features?: FakeServer['features'];
  readonly name?: string;
  readonly store?: MemorySceneStore;
  readonly backOff?: BackOff;
  readonly patches?: PatchSource;
  /** Whether the one worker decodes what it gets at once, which it does unless told otherwise. */
  readonly decodesAtOnce?: boolean;
}

/** A session whose server is the test; its lattice has 3 x 3 x 3 points over the unit cube. */
export class SessionFixture {
  readonly server = new FakeServer();
  readonly sockets = new FakeStreams();
  readonly watches = new FakeStreams();
  readonly worker: FakeWorker;
  readonly store: MemorySceneStore;
  readonly surface: SurfaceMesh;
  readonly said: string[] = [];
  readonly notKept: string[] = [];
  readonly states: string[] = [];
  readonly session: LiveSession;
  /** What the page wakes, until the session is closed. */
  awake: Wakeable | undefined;

  constructor(options: Options = {}) {
    this.store = options.store ?? new MemorySceneStore();
    this.surface = new SurfaceMesh(options.patches ?? noPatches);
    this.worker = new FakeWorker(decoderWasm, options.decodesAtOnce ?? true);
    this.server.features = options.features ?? [];
    this.server.meshes.set('mesh-1', new Uint8Array([1, 2, 3]));
    this.session = new LiveSession('scene-0001', {
      server: this.server.client, info: this.server.info(), streams: [this.sockets.open, this.watches.open],
      pool: new DecodePool([this.worker], decoderWasm), surface: this.surface,
      keeper: new SceneKeeper(this.server.client, this.store, 'scene-0001'),
      backOff: options.backOff ?? { firstMs: 1, lastMs: 2 },
      wakes: (connection) => {
        this.awake = connection;
        return () => (this.awake = undefined);
      },
      ...(options.name && { name: options.name }),
    });
    this.session.on('refused', (text) => this.said.push(text));
    this.session.on('notKept', (text) => this.notKept.push(text));
    this.session.on('status', ({ state }) => this.states.push(state));
    this.session.ready.catch(() => undefined);
  }

  /** Connected, with the first lattice. */
  static async live(options: Options = {}): Promise<SessionFixture> {
    const fixture = new SessionFixture(options);
    fixture.stream.hello(fixture.server.bootId);
    fixture.state();
    await fixture.session.ready;
    await until(async () => Boolean(await fixture.store.mesh('mesh-1')));
    return fixture;
  }

  get stream(): FakeStream {
    return this.sockets.newest;
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

  /** x of a control point as it is shown. */
  x(index: number): number {
    return this.session.lattice.points[3 * index]!;
  }
}

/** Control points at 0, 1/2 and 1 per axis: number 0 at the origin, 1 at (0.5, 0, 0). */
export function cubeLattice(): Lattice {
  return fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [3, 3, 3], degree: [2, 2, 2], padding: 0 });
}

/** Waits, for a minute at most, until something holds. */
export async function until(holds: () => boolean | Promise<boolean>): Promise<void> {
  for (const end = Date.now() + 60_000; Date.now() < end;) {
    if (await holds()) return;
    await new Promise((resolve) => setTimeout(resolve, 1));
  }
  throw new Error(`waited in vain: ${holds.toString()}`);
}

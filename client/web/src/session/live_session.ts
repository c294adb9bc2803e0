// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Code } from '@connectrpc/connect';
import type { Hello, Presence as PresenceMessage, SceneEvent } from 'latticed/v1/event_pb';
import { Feature, type ServerInfo } from 'latticed/v1/server_pb';
import type { DecodePool } from '../decode/decode_pool';
import type { Lattice, Vec3 } from '../lattice/lattice';
import type { Surface } from '../surface/surface';
import type { SurfaceSink } from '../surface/surface_sink';
import { edits, fromEdit, toSurfacePoint } from '../wire/edit_message';
import { randomUuid } from '../wire/ids';
import { fromVector } from '../wire/lattice_message';
import type { LatticedServer } from '../wire/latticed_server';
import type { OpenStream, WatchRequestInit } from '../wire/scene_stream';
import { ServerError } from '../wire/server_error';
import { fromView, toView } from '../wire/view_message';
import { inWords } from '../wire/words';
import { targetsOf } from './edit_targets';
import type { LatticeEdit, SurfacePoint } from './lattice_edit';
import { LatticeSync } from './lattice_sync';
import { Listeners } from './listeners';
import { Presences } from './presences';
import { SceneConnection, type BackOff, type ConnectionHost } from './scene_connection';
import type { SceneKeeper } from './scene_keeper';
import type { Gesture, SceneSession, SessionEvents, SessionStatus, ViewRequest } from './scene_session';
import { UpdateReceiver, type ReceivedUpdate } from './update_receiver';

/** What a session works with. */
export interface SessionParts {
  readonly server: LatticedServer;
  readonly info: ServerInfo;
  readonly streams: readonly OpenStream[];
  readonly pool: DecodePool;
  readonly surface: SurfaceSink;
  readonly keeper: SceneKeeper;
  readonly name?: string;
  readonly colour?: number;
  readonly view?: ViewRequest;
  readonly backOff?: BackOff;
}

/** SceneSession over the wire. Its lattice is there once `ready` has resolved. */
export class LiveSession implements SceneSession, ConnectionHost {
  readonly editorId = randomUuid();
  /** Resolves with the first lattice; rejects where the scene cannot be had. */
  readonly ready: Promise<void>;
  private readonly listeners = new Listeners<SessionEvents>();
  private readonly sync = new LatticeSync((batch) => this.connection.send({ message: { case: 'edit', value: batch } }), {
    ready: () => this.latticeReady(),
    structureChanged: (lattice) => this.structureChanged(lattice),
    pointsMoved: (indices) => this.listeners.emit('points', indices),
    serverMoved: () => this.parts.keeper.changed(() => this.lattice),
    refused: (text) => this.listeners.emit('refused', text),
  });
  private readonly receiver: UpdateReceiver;
  private readonly presences = new Presences((selected) => this.showPresence(selected));
  private readonly connection: SceneConnection;
  private view: ViewRequest;
  private grantedView: Required<ViewRequest> | undefined;  // of the newest update
  private resumeToken: Uint8Array<ArrayBuffer> = new Uint8Array();
  private restored = false;
  private presenceAllowed: boolean;
  private shown: SessionStatus = { state: 'connecting', text: 'Connecting …' };
  private settle!: { resolve: () => void; reject: (error: Error) => void };

  constructor(readonly sceneId: string, private readonly parts: SessionParts) {
    this.view = parts.view ?? {};
    this.presenceAllowed = parts.info.features.includes(Feature.PRESENCE);
    this.ready = new Promise((resolve, reject) => (this.settle = { resolve, reject }));
    this.receiver = new UpdateReceiver(parts.pool, (update) => this.updated(update), (error) => this.useless(error));
    this.connection = new SceneConnection(parts.streams, this, parts.backOff);
    this.connection.open();
  }

  get lattice(): Lattice {
    const { shown } = this.sync;
    if (!shown) throw new Error('the session is not ready');
    return shown;
  }

  get surface(): Surface {
    return this.parts.surface;
  }

  get status(): SessionStatus {
    return this.shown;
  }

  on<K extends keyof SessionEvents>(event: K, listener: SessionEvents[K]): () => void {
    return this.listeners.on(event, listener);
  }

  gesture(): Gesture {
    return this.sync.gesture();
  }

  apply(edit: LatticeEdit): void {
    this.sync.step(fromEdit(edit), targetsOf(edit, this.lattice.points));
  }

  undo(): void {
    this.sync.step(edits.undo());
  }

  redo(): void {
    this.sync.step(edits.redo());
  }

  reset(to: 'identity' | 'initial'): void {
    this.sync.step(edits.reset(to));
  }

  insertKnot(axis: 0 | 1 | 2, value: number): void {
    this.sync.step(edits.insertKnot(axis, value));
  }

  replace(points: Float64Array): void {
    const indices = Uint32Array.from({ length: this.lattice.count }, (_, i) => i);
    this.sync.step(edits.replace(points), { indices, positions: points.slice() });
  }

  setView(view: ViewRequest): void {
    this.view = { ...this.view, ...view };
    this.connection.send({ message: { case: 'control', value: { view: fromView(this.view) } } });
  }

  announce(selected: Uint32Array): void {
    if (this.presenceAllowed) this.presences.announce(selected);
  }

  async pick(origin: Vec3, direction: Vec3): Promise<SurfacePoint | undefined> {
    if (!this.parts.info.features.includes(Feature.PICK)) return undefined;
    try {
      return toSurfacePoint(await this.parts.server.scenes.pick({
        scene: this.sceneId, ray: { origin: fromVector(origin), direction: fromVector(direction) } }));
    } catch (error) {
      const failure = ServerError.fromConnect(error);
      if (failure.code === Code.NotFound && failure.reason === 'NOTHING_HIT') return undefined;
      throw failure;
    }
  }

  close(): void {
    this.connection.close();
    this.receiver.close();
    this.presences.close();
    this.parts.keeper.close();
    this.parts.surface.dispose();
  }

  // ConnectionHost

  request(): WatchRequestInit {
    return { scene: this.sceneId, editorId: this.editorId, view: fromView(this.view), resumeToken: this.resumeToken };
  }

  opened(hello: Hello): void {
    this.parts.keeper.runsOn(hello.bootId);
    this.sync.opened();
    this.presences.opened();
    if (this.restored) this.tell('restored', 'The server was restarted; this browser restored mesh and lattice. What was done before cannot be undone.');
    else this.tell('live', 'Connected.');
  }

  event({ event }: SceneEvent): void {
    try {
      this.take(event);
    } catch (error) {
      this.useless(error as Error);
    }
  }

  retrying(error: ServerError | undefined): void {
    this.lost();
    this.restored = false;
    if (error?.reason === 'OUT_OF_MEMORY') this.takeViewBack(error);
    this.tell('retrying', error ? `${inWords(error)} Trying again …` : 'The connection ended. Connecting again …');
  }

  async ended(error: ServerError): Promise<boolean> {
    this.lost();
    if (error.code === Code.PermissionDenied && this.presenceAllowed) {  // a token that may only look
      this.presenceAllowed = false;
      return true;
    }
    try {
      if (error.code === Code.NotFound && await this.parts.keeper.restore(this.sync.shown)) {
        this.restored = true;
        this.resumeToken = new Uint8Array();
        this.sync.restored();
        return true;
      }
      this.fail(error);
    } catch (failure) {
      this.fail(failure);
    }
    return false;
  }

  async probe(): Promise<ServerError | undefined> {
    try {
      await this.parts.server.server.getServerInfo({});
      return undefined;
    } catch (error) {
      return ServerError.fromConnect(error);
    }
  }

  private take(event: SceneEvent['event']): void {
    switch (event.case) {
      case 'latticeState': return this.sync.takeState(event.value);
      case 'latticeDelta': return this.sync.takeDelta(event.value);
      case 'topology': return this.receiver.topology(event.value);
      case 'quantisation': return this.receiver.quantisation(event.value);
      case 'updateBegin': return this.receiver.begin(event.value);
      case 'chunks': return this.receiver.chunks(event.value);
      case 'updateEnd': return this.receiver.end(event.value);
      case 'editResult': return this.sync.takeResult(event.value);
      case 'presence': return this.takePresence(event.value);
    }
  }

  private latticeReady(): void {
    this.listeners.emit('lattice', this.lattice);
    this.settle.resolve();
    void this.keep();
  }

  private structureChanged(lattice: Lattice): void {
    this.parts.surface.structureChanged();
    this.listeners.emit('lattice', lattice);
  }

  private takePresence(presence: PresenceMessage): void {
    if (presence.editorId === this.editorId) return;
    this.presences.take(presence);
    this.listeners.emit('presence', this.presences.others);
  }

  private updated(update: ReceivedUpdate): void {
    const { end, surface } = update;
    const start = performance.now();
    if (surface) this.parts.surface.apply(surface);
    const upload = performance.now() - start;
    this.resumeToken = end.resumeToken as Uint8Array<ArrayBuffer>;
    if (update.view && end.fullDetail) this.grantedView = toView(update.view);
    this.connection.send({ message: { case: 'control', value: { ackedUpdateId: end.updateId } } });
    const msFromEdit = this.sync.ageOf(end.appliedSequence);
    const { evaluateUs = 0, encodeUs = 0 } = end.timings ?? {};
    this.listeners.emit('update', {
      revision: Number(end.revision), ...(msFromEdit !== undefined && { msFromEdit }), bytes: update.bytes,
      patchesSent: update.patches, patchesAll: this.parts.surface.patchCount, fullDetail: end.fullDetail,
      times: { server: (evaluateUs + encodeUs) / 1000, transfer: update.transferMs, decode: update.decodeMs, upload },
    });
  }

  private showPresence(selected: number[]): void {
    if (!this.presenceAllowed || this.shown.state === 'retrying') return;
    const { name = '', colour = 0 } = this.parts;
    this.connection.send({ message: { case: 'presence', value: { name, colour, selectedIndices: selected } } });
  }

  /** A view that is too large ends the stream: another with the same view would end as well. */
  private takeViewBack(error: ServerError): void {
    const { grantedView, view } = this;
    const keys = Object.keys(view) as (keyof ViewRequest)[];
    if (!grantedView || keys.every((key) => view[key] === grantedView[key])) return;
    this.view = grantedView;
    this.listeners.emit('refused', inWords(error));
    this.listeners.emit('view', grantedView);
  }

  private async keep(): Promise<void> {
    try {
      const scene = await this.parts.server.scenes.getScene({ scene: this.sceneId });
      await this.parts.keeper.keep(scene, this.lattice);
    } catch (error) {
      console.warn('latticed: the scene is not kept for a restart of the server:', error);
    }
  }

  /** What came cannot be read: everything is asked for anew. */
  private useless(error: Error): void {
    this.resumeToken = new Uint8Array();
    this.lost();
    this.tell('retrying', `What the server sent cannot be shown (${error.message}). Asking again …`);
    this.connection.reopen();
  }

  private lost(): void {
    this.sync.lost();
    this.receiver.reset();
  }

  private fail(error: unknown): void {
    this.settle.reject(new Error(inWords(error)));
    this.tell('failed', inWords(error));
  }

  private tell(state: SessionStatus['state'], text: string): void {
    this.shown = { state, text };
    this.listeners.emit('status', this.shown);
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Code } from '@connectrpc/connect';
import type { Hello, Presence as PresenceMessage, SceneEvent } from 'latticed/v1/event_pb';
import { Feature, type ServerInfo } from 'latticed/v1/server_pb';
import type { ViewOptions } from 'latticed/v1/view_pb';
import type { DecodePool } from '../decode/decode_pool';
import { clipped } from '../state/person';
import type { SurfaceMesh } from '../surface/surface_mesh';
import { fromCamera } from '../wire/camera_message';
import type { LatticedServer } from '../wire/latticed_server';
import type { MeshDownloads } from '../wire/mesh_downloads';
import type { DeformRequestInit, OpenStream, WatchRequestInit } from '../wire/scene_stream';
import { ServerError } from '../wire/server_error';
import { fromView, toView } from '../wire/view_message';
import { inWords, tokenWanted } from '../wire/words';
import { AckPace } from './ack_pace';
import type { LatticeSync } from './edits/lattice_sync';
import { measuredChoice, type EncodingChoice } from './encoding_choice';
import type { Listeners } from './listeners';
import { Presences } from './presences';
import { SceneConnection, type AfterEnd, type BackOff, type ConnectionHost, type Wakeable } from './scene_connection';
import type { Presence, SessionEvents, SessionStatus, ViewRequest } from './scene_session';
import { UpdateReceiver, type ReceivedUpdate } from './update_receiver';

export interface SessionOptions {
  /** The first view. */
  readonly view?: ViewRequest;
}

/** The parts that a session works with. */
export interface SessionParts extends SessionOptions {
  readonly server: LatticedServer;
  readonly info: ServerInfo;
  readonly streams: readonly OpenStream[];
  readonly pool: DecodePool;
  readonly surface: SurfaceMesh;
  readonly downloads: MeshDownloads;
  readonly backOff?: BackOff;
  /** Wakes the connection when the page wakes up; the function returned ends that. */
  readonly wakes?: (connection: Wakeable) => () => void;
}

/** Whether the server has no such view: of any scene, of this one's pipeline, or, of an earlier server, of one with vertex weights. */
function refusesView(error: ServerError): boolean {
  return error.code === Code.InvalidArgument || error.reason === 'VERTEX_WEIGHTS';
}

/**
 * The streams of a session, one after another. Their messages go to the lattice, the surface and the listeners. A lost
 * stream is resumed by the next one.
 */
export class SessionStream implements ConnectionHost {
  private static readonly PROBE_MS = 5000;
  private static readonly USUAL_SEGMENTS = 10;

  private readonly receiver: UpdateReceiver;
  private readonly acks = new AckPace();
  private readonly presences = new Presences((own) => this.showPresence(own));
  private readonly connection: SceneConnection;
  private readonly endWakes: (() => void) | undefined;
  private readonly endTokens: () => void;
  private view: ViewRequest;
  private grantedView: Required<ViewRequest> | undefined;  // of the newest update with full detail
  private choice: EncodingChoice | undefined;  // of an encoding that is left open
  private isChoosing = false;
  private resumeToken: Uint8Array<ArrayBuffer> = new Uint8Array();
  private startsAnew = false;  // until the first update of a stream that starts anew
  private shown: SessionStatus = { state: 'connecting', text: 'Connecting …' };

  constructor(
    private readonly sceneId: string,
    private readonly editorId: string,
    private readonly parts: SessionParts,
    private readonly sync: LatticeSync,
    private readonly listeners: Listeners<SessionEvents>,
  ) {
    this.view = parts.view ?? {};
    this.receiver = new UpdateReceiver(parts.pool, (update) => this.updated(update), (error) => this.useless(error));
    this.connection = new SceneConnection(parts.streams, this, parts.backOff);
    this.endWakes = parts.wakes?.(this.connection);
    this.endTokens = parts.server.onToken(() => this.goOnWithToken());
    this.connection.open();
  }

  private get presenceAllowed(): boolean {
    return this.parts.info.features.includes(Feature.PRESENCE) && this.parts.server.mayEdit;
  }

  get status(): SessionStatus {
    return this.shown;
  }

  /** The other editors that are known, by editor id. Changes with each `presence`. */
  get others(): ReadonlyMap<string, Presence> {
    return this.presences.others;
  }

  /** The most code points of a person's name that the server takes. */
  get longestName(): number {
    return this.parts.info.limits?.maxPresenceName ?? 0;
  }

  send(message: DeformRequestInit): void {
    this.connection.send(message);
  }

  /** What was asked for last. */
  get askedView(): ViewRequest {
    return this.view;
  }

  setView(view: ViewRequest): void {
    this.view = { ...this.view, ...view };
    this.send({ message: { case: 'control', value: { view: this.viewOptions } } });
  }

  private get viewOptions(): ViewOptions {
    return fromView(this.view, this.choice?.encoding);
  }

  /** Chooses the encoding that is left open, once something was decoded. */
  private async choose(): Promise<void> {
    if (this.choice || this.isChoosing) return;
    this.isChoosing = true;
    const { server, info, pool } = this.parts;
    this.choice = await measuredChoice(server, info, pool);
    this.isChoosing = false;
    if (this.choice?.encoding === 'meshopt') this.setView({});
  }

  announce(change: Partial<Presence>): void {
    this.presences.announce(change);
  }

  close(): void {
    this.endWakes?.();
    this.endTokens();
    this.connection.close();
    this.receiver.close();
    this.presences.close();
  }

  // ConnectionHost

  request(): WatchRequestInit {
    return {
      scene: this.sceneId, editorId: this.editorId, view: this.viewOptions, resumeToken: this.resumeToken,
      maxUnackedUpdates: AckPace.AT_ONCE };
  }

  opened({ headRevision }: Hello): void {
    this.acks.opened();
    this.sync.opened(headRevision);
    this.presences.opened();
    this.listeners.emit('presence', this.presences.others);
    this.tell('live', this.parts.info.durable ? 'Connected.' : 'Connected. This server keeps scenes only in memory.');
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
    const isFull = error?.reason === 'OUT_OF_MEMORY';
    if (isFull) this.takeViewBack(error);
    const advice = isFull ? ' Fewer segments need less memory.' : '';
    this.tell('retrying', error ? `${inWords(error)}${advice} Trying again …` : 'The connection ended. Connecting again …');
  }

  async ended(error: ServerError): Promise<AfterEnd> {
    this.lost();
    if (error.code === Code.PermissionDenied && this.presenceAllowed) {  // the token allows only to watch
      this.parts.server.mayEdit = false;
      return 'open';
    }
    if (error.code === Code.Unauthenticated) {
      this.tell('token', tokenWanted(this.parts.server.token !== undefined));
      return 'stop';
    }
    if (this.dropPatches(error) || this.dropTolerance(error)) return 'open';
    this.tell('failed', error.code === Code.NotFound && this.sync.shown ? this.goneInWords : inWords(error));
    return 'stop';
  }

  private get goneInWords(): string {
    const why = this.parts.info.durable ? 'somebody deleted it, or nobody used it for too long' : 'it was restarted and keeps nothing, or somebody deleted it';
    return `The server no longer has this scene: ${why}. The lattice can still be saved here.`;
  }

  async probe(): Promise<ServerError | undefined> {
    try {
      await this.parts.server.server.getServerInfo({}, { timeoutMs: SessionStream.PROBE_MS });
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
      case 'patchLattice': return this.receiver.patchLattice(event.value);
      case 'chunks': return this.receiver.chunks(event.value);
      case 'updateEnd': return this.receiver.end(event.value);
      case 'editResult': return this.sync.takeResult(event.value);
      case 'presence': return this.takePresence(event.value);
    }
  }

  private takePresence(presence: PresenceMessage): void {
    if (presence.editorId === this.editorId) return;
    this.presences.take(presence);
    this.listeners.emit('presence', this.presences.others);
  }

  private updated(update: ReceivedUpdate): void {
    const { end, surface, edges, sum } = update;
    const start = performance.now();
    if (surface) this.parts.surface.apply(surface);
    if (edges) this.parts.surface.edgeBounds.take(edges);
    this.parts.surface.edgeBounds.updated(this.sync.structureAt(end.revision), sum);
    const upload = performance.now() - start;
    if (!update.ofLostStream) this.startsAnew = false;
    if (!this.startsAnew) this.resumeToken = end.resumeToken as Uint8Array<ArrayBuffer>;
    const isOpen = this.view.encoding === 'auto';
    if (update.view && end.fullDetail) this.grantedView = { ...toView(update.view), ...(isOpen && { encoding: 'auto' }) };
    if (isOpen) void this.choose();
    if (!update.ofLostStream) {
      this.send({ message: { case: 'control', value: { ackedUpdateId: this.acks.take(end.updateId, update.unseen) } } });
    }
    const msFromEdit = this.sync.ageOf(end.appliedSequence);
    const { evaluateUs = 0, encodeUs = 0 } = end.timings ?? {};
    this.listeners.emit('update', {
      revision: Number(end.revision), ...(msFromEdit !== undefined && { msFromEdit }), bytes: update.bytes,
      patchesSent: update.patches, patchesAll: edges?.layout.patchCount ?? this.parts.surface.patchCount, points: this.parts.surface.pointCount,
      certifiedError: end.certifiedError, fullDetail: end.fullDetail,
      ...(isOpen && this.choice && { chosen: `${this.choice.encoding}: ${this.choice.reason}` }),
      times: { server: (evaluateUs + encodeUs) / 1000, transfer: update.transferMs, decode: update.decodeMs, upload },
    });
  }

  private showPresence({ name, colour, selected, lattice, camera, following }: Presence): void {
    if (!this.presenceAllowed || this.shown.state === 'retrying') return;
    const seen = camera && fromCamera(camera);
    const value = { name: clipped(name, this.longestName), colour, selectedIndices: Array.from(selected), lattice, following };
    this.send({ message: { case: 'presence', value: { ...value, ...(seen && { camera: seen }) } } });
  }

  /** Restores the last granted view. A view that is too large ends the stream, and would end the next one too. */
  private takeViewBack(error: ServerError): void {
    const { grantedView, view } = this;
    const keys = Object.keys(view) as (keyof ViewRequest)[];
    const isByTolerance = view.tolerance! > 0;
    // The server needs memory for the points that segments allow.
    if (!grantedView && isByTolerance) this.view = { ...view, segments: Math.min(view.segments!, SessionStream.USUAL_SEGMENTS) };
    if (!grantedView || keys.every((key) => view[key] === grantedView[key])) return;
    this.view = grantedView;
    this.listeners.emit('refused', inWords(error));
    this.listeners.emit('view', grantedView);
  }

  /** Goes on with points from the server, if it has no patches for this scene. Returns whether that was it. */
  private dropPatches(error: ServerError): boolean {
    if (!refusesView(error) || this.view.encoding !== 'patches') return false;
    this.view = { ...this.view, encoding: 'auto' };
    this.startAnew();
    this.listeners.emit('view', this.view);
    return true;
  }

  /**
   * Goes on with the same segments everywhere, if the server refused a tolerance: the scene's grid has become too coarse for
   * it, or an earlier server has none for this scene. Returns whether that was it.
   */
  private dropTolerance(error: ServerError): boolean {
    if (!refusesView(error) || !(this.view.tolerance! > 0)) return false;
    const segments = Math.min(this.view.segments ?? 0, SessionStream.USUAL_SEGMENTS);
    this.view = { ...this.view, segments, tolerance: 0, maxPoints: 0 };
    this.startAnew();
    this.listeners.emit('refused', inWords(error));
    this.listeners.emit('view', { tolerance: 0 });
    return true;
  }

  /** The page has another token, with which the stream is opened anew: it may allow more, or less. */
  private goOnWithToken(): void {
    this.lost();
    this.tell('retrying', 'Connecting with the new token …');
    this.connection.open();
  }

  /** The server's data cannot be read: everything is requested again. */
  private useless(error: Error): void {
    this.startAnew();
    this.lost();
    this.tell('retrying', `The server's data cannot be shown (${error.message}). Asking again …`);
    this.connection.reopen();
  }

  /** The next stream sends everything, even if updates of earlier streams are still being decoded. */
  private startAnew(): void {
    this.resumeToken = new Uint8Array();
    this.startsAnew = true;
  }

  private lost(): void {
    this.sync.lost();
    this.receiver.reset();
  }

  private tell(state: SessionStatus['state'], text: string): void {
    this.shown = { state, text };
    this.listeners.emit('status', this.shown);
  }
}

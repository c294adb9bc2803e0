// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Code } from '@connectrpc/connect';
import { Measure } from 'latticed/v1/measure_pb';
import { Feature } from 'latticed/v1/server_pb';
import type { Constraints } from '../lattice/constraints';
import { indicesTo } from '../lattice/index_sets';
import type { Lattice, Vec3 } from '../lattice/lattice';
import type { SurfaceMesh } from '../surface/surface_mesh';
import { edits, fromEdit, toSurfacePoint } from '../wire/edit_message';
import { randomUuid } from '../wire/ids';
import { toFolds, type Folds } from '../wire/fold_message';
import { fromVector } from '../wire/lattice_message';
import type { DownloadedMesh } from '../wire/mesh_downloads';
import type { LatticedServer } from '../wire/latticed_server';
import { ServerError } from '../wire/server_error';
import { targetsOf } from './edits/edit_targets';
import type { OnAnswer } from './edits/edit_queue';
import type { LatticeEdit, SurfacePoint } from './edits/lattice_edit';
import { LatticeSync } from './edits/lattice_sync';
import { Listeners } from './listeners';
import type { Gesture, GestureListener, Presence, SessionEvents, SessionStatus, ViewRequest } from './scene_session';
import { SessionStream, type SessionParts } from './session_stream';
import type { NumberedLattices } from './sum_ahead';

/** A scene that is watched and edited. It reconnects by itself. It has a lattice once `ready` has resolved. */
export class LiveSession {
  private static readonly PICK_MS = 10_000;  // the browser may take a dead connection for alive

  /** This window's id as an editor. */
  readonly editorId = randomUuid();
  /** Resolves with the first lattice; rejects if the scene cannot be opened. */
  readonly ready: Promise<void>;
  private readonly listeners = new Listeners<SessionEvents>();
  private readonly sync: LatticeSync;
  private readonly stream: SessionStream;

  constructor(readonly sceneId: string, private readonly parts: SessionParts) {
    const { surface } = parts;
    this.ready = new Promise((resolve, reject) => {
      this.on('lattice', () => resolve());
      this.on('status', ({ state, text }) => state === 'failed' && reject(new Error(text)));
    });
    this.on('lattice', () => surface.structureChanged());
    this.on('status', ({ state }) => state === 'live' && surface.reconnected());
    this.sync = new LatticeSync((batch) => this.stream.send({ message: { case: 'edit', value: batch } }), this.listeners);
    this.stream = new SessionStream(sceneId, this.editorId, parts, this.sync, this.listeners);
  }

  /** The server's newest lattice with this window's edits on top. A new object after a change of structure. */
  get lattice(): Lattice {
    const { shown } = this.sync;
    if (!shown) throw new Error('the session is not ready');
    return shown;
  }

  /** How many lattices the scene has; their displacements add. */
  get latticeCount(): number {
    return this.sync.numbers.length;
  }

  /** Their numbers, ascending: those of removed lattices are left out. */
  get latticeNumbers(): readonly number[] {
    return this.sync.numbers;
  }

  /** The number of the one that is shown and edited. */
  get latticeIndex(): number {
    return this.sync.index;
  }

  /** Which one `lattice` is: not yet the chosen one while an edit waits for its answer. */
  get shownLatticeIndex(): number {
    return this.sync.shownIndex;
  }

  /** Whether the scene still has the lattice that is shown: one that was removed stays until no edit waits for its answer. */
  get hasShownLattice(): boolean {
    return this.sync.isThere;
  }

  /** Shows and edits another lattice, as soon as no edit waits for its answer: event 'lattice'. */
  chooseLattice(index: number): void {
    this.sync.choose(index);
  }

  /** The server's lattices, all of them. */
  get lattices(): readonly Lattice[] {
    return this.sync.lattices;
  }

  /** All of them by number; the one that is shown with this window's edits. */
  get numberedLattices(): NumberedLattices {
    return this.sync.numbered;
  }

  /** What edits keep. */
  get constraints(): Constraints {
    return this.sync.constraints;
  }

  /** The control points that no edit moves. */
  get held(): ReadonlySet<number> {
    return this.sync.held;
  }

  /** One edit that sets what later edits keep, in place of what they kept. */
  constrain(constraints: Constraints): void {
    this.sync.step(edits.setConstraints(constraints));
  }

  /** The volume that the exact surface encloses, in world units cubed. Rejects with OPEN_SURFACE if it encloses none. */
  async measureVolume(): Promise<number> {
    const request = { scene: this.sceneId, measures: [Measure.VOLUME] };
    const { volume = 0 } = await this.parts.server.scenes.measureScene(request, { timeoutMs: LiveSession.PICK_MS });
    return volume;
  }

  get server(): LatticedServer {
    return this.parts.server;
  }

  get surface(): SurfaceMesh {
    return this.parts.surface;
  }

  get status(): SessionStatus {
    return this.stream.status;
  }

  /** Returns a function that removes the listener. */
  on<K extends keyof SessionEvents>(event: K, listener: SessionEvents[K]): () => void {
    return this.listeners.on(event, listener);
  }

  /** Whether the server refuses edits of this window that make a new fold. */
  set refuseFolds(on: boolean) {
    this.sync.refuseFolds = on;
  }

  gesture(listener?: GestureListener): Gesture {
    return this.sync.gesture(listener);
  }

  /** One edit that is an undo step of its own. */
  apply(edit: LatticeEdit): void {
    this.sync.step(fromEdit(edit), targetsOf(edit, this.lattice.points));
  }

  /** False once the server has said that this page's token allows only to watch. It may become true with another token. */
  get mayEdit(): boolean {
    return this.parts.server.mayEdit;
  }

  /** Whether this page's token may make, list and revoke shares of the scene. */
  get mayShare(): boolean {
    return this.mayEdit && !this.parts.server.isOfShare;
  }

  /** Whether the server's history holds a step of this window to undo, by its newest answer. */
  get canUndo(): boolean {
    return this.sync.canUndo;
  }

  get canRedo(): boolean {
    return this.sync.canRedo;
  }

  undo(): void {
    this.sync.undo();
  }

  redo(): void {
    this.sync.redo();
  }

  reset(to: 'identity' | 'initial'): void {
    this.sync.step(edits.reset(to));
  }

  insertKnot(axis: 0 | 1 | 2, value: number): void {
    this.sync.step(edits.insertKnot(axis, value));
  }

  replaceLattice(lattice: Lattice, keepShape: boolean): void {
    this.sync.step(edits.replaceLattice(lattice, keepShape));
  }

  /** Adds a lattice to the scene's. It is shown when the server has taken it. */
  addLattice(lattice: Lattice): void {
    this.sync.add(lattice);
  }

  /** Takes the lattice that is shown away from the scene's. Another one is shown when the server has done so. */
  removeLattice(): void {
    this.sync.step(edits.removeLattice());
  }

  /** Weights of some vertices of the mesh, in their order: an undo step. */
  setWeights(indices: readonly number[], weights: Float32Array): void {
    this.sync.step(edits.setWeights(indices, weights));
  }

  /** All vertices follow the lattice again. */
  clearWeights(): void {
    this.sync.step(edits.clearWeights());
  }

  /**
   * Moves control points, all without indices, as a parent lattice of strength 1 moves the world at their places. They are shown
   * there once the server has answered.
   */
  carry(indices: Iterable<number>, parent: Lattice, answered: OnAnswer): void {
    this.sync.step(edits.carry(indices, parent), undefined, answered);
  }

  /** All control points at once, x y z each. */
  replace(points: Float64Array): void {
    this.sync.step(edits.replace(points), { indices: Uint32Array.from(indicesTo(this.lattice.count)), positions: points.slice() });
  }

  /** Whether the lattice that is shown is the server's at this revision, without edits that it lacks. */
  isAt(revision: number): boolean {
    return this.sync.isAt(BigInt(revision));
  }

  /** Whether all lattices are the server's at this revision, without edits that it lacks. */
  areAllAt(revision: number): boolean {
    return this.sync.areAt(BigInt(revision));
  }

  /** What was asked for last. */
  get askedView(): ViewRequest {
    return this.stream.askedView;
  }

  setView(view: ViewRequest): void {
    this.stream.setView(view);
  }

  /** Changes what other windows see of this one: see Presences. */
  announce(change: Partial<Presence>): void {
    this.stream.announce(change);
  }

  /** The other editors that are known, by editor id. Changes with each `presence`. */
  get others(): ReadonlyMap<string, Presence> {
    return this.stream.others;
  }

  /** The most code points of a person's name that the server takes. */
  get longestName(): number {
    return this.stream.longestName;
  }

  /** The first point of the deformed surface on a ray in world units. Undefined also if the server has no Pick. */
  async pick(origin: Vec3, direction: Vec3): Promise<SurfacePoint | undefined> {
    if (!this.parts.info.features.includes(Feature.PICK)) return undefined;
    try {
      return toSurfacePoint(await this.parts.server.scenes.pick({
        scene: this.sceneId, ray: { origin: fromVector(origin), direction: fromVector(direction) },
      }, { timeoutMs: LiveSession.PICK_MS }));
    } catch (error) {
      const failure = ServerError.fromConnect(error);
      if (failure.code === Code.NotFound && failure.reason === 'NOTHING_HIT') return undefined;
      throw failure;
    }
  }

  /** Where the server's newest lattice folds around the mesh. Undefined if the server cannot tell. */
  async certifyFolds(): Promise<Folds | undefined> {
    try {
      return toFolds(await this.parts.server.scenes.certifyFolds({ scene: this.sceneId }, { timeoutMs: LiveSession.PICK_MS }));
    } catch (error) {
      const failure = ServerError.fromConnect(error);
      if (failure.code === Code.Unimplemented) return undefined;
      throw failure;
    }
  }

  /** The scene's mesh as it was uploaded. */
  downloadMesh(id: string): Promise<DownloadedMesh> {
    return this.parts.downloads.downloadMesh(id);
  }

  close(): void {
    this.stream.close();
    this.parts.downloads.close();
    this.parts.surface.dispose();
  }
}

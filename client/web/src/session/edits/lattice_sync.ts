// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { GesturePhase, type Edit, type EditBatch, type EditResult } from 'latticed/v1/edit_pb';
import type { LatticeDelta } from 'latticed/v1/event_pb';
import type { LatticeState } from 'latticed/v1/lattice_pb';
import { heldPoints, NO_CONSTRAINTS, type Constraints } from '../../lattice/constraints';
import { indicesTo } from '../../lattice/index_sets';
import type { Lattice } from '../../lattice/lattice';
import type { LatticeStructure } from '../../lattice/grid';
import { toConstraints } from '../../wire/constraint_message';
import { edits } from '../../wire/edit_message';
import { toLattice } from '../../wire/lattice_message';
import { ServerError } from '../../wire/server_error';
import { inWords } from '../../wire/words';
import { EditQueue, type OnAnswer } from './edit_queue';
import type { Targets } from './edit_targets';
import { LatticeModel } from './lattice_model';
import { LatticeStates } from './lattice_states';
import { OwnGesture } from './own_gesture';
import { Removals } from './removals';
import { UndoSteps } from './undo_steps';
import type { Listeners } from '../listeners';
import type { Gesture, GestureListener, SessionEvents } from '../scene_session';
import type { NumberedLattices } from '../sum_ahead';

/** Keeps the lattice that is shown in step with the server's: edits go out, states and deltas come in. */
export class LatticeSync {
  private static readonly DROPPED = 'The lattice got other control points meanwhile, so unsent edits were dropped.';
  private static readonly MADE_AGAIN = 'The scene was made again meanwhile, so unsent edits were dropped.';
  private static readonly CHANGED = 'The lattice got other control points meanwhile, so your move ended.';

  private readonly states = new LatticeStates();
  private readonly stepsOf: UndoSteps[] = [];  // by lattice
  private readonly removals = new Removals(this.states);
  private edited = 0;                          // which lattice is shown
  private wanted = 0;                          // which is to be, once no edit waits for its answer
  private readonly queue: EditQueue;
  private model: LatticeModel | undefined;
  private kept = NO_CONSTRAINTS;
  private keptStill = new Set<number>();
  private openGesture: OwnGesture | undefined;
  private structureSince = 0n;  // the revision with which the newest structure came

  constructor(send: (batch: EditBatch) => void, private readonly listeners: Listeners<SessionEvents>) {
    this.queue = new EditQueue((batch, namesLattice) => {
      // Weights are of the mesh, and lattice 0 has their history, even where it was removed.
      if (!namesLattice) batch.lattice = batch.edits[0]?.edit.case === 'setWeights' ? 0 : this.edited;
      send(batch);
    });
  }

  /** The numbers of the scene's lattices, ascending. Their displacements add. */
  get numbers(): readonly number[] {
    return this.states.numbers;
  }

  /** Which of them is chosen, from 0: it is shown and edited as soon as no edit waits for its answer. */
  get index(): number {
    return this.wanted;
  }

  /** Which of them is shown and edited now. */
  get shownIndex(): number {
    return this.edited;
  }

  /** Shows and edits another one, with undo steps of its own, as soon as no edit waits for its answer. */
  choose(index: number): void {
    this.wanted = index;
    this.openGesture?.giveWay();
    this.turn();
  }

  /** The server's lattices, all of them. */
  get lattices(): readonly Lattice[] {
    return this.states.all.map(({ lattice }) => toLattice(lattice!));
  }

  /** All of them by number; the one that is shown with this window's edits. */
  get numbered(): NumberedLattices {
    const { model } = this;
    return new Map(this.states.all.map((state) => [state.index, model && state.index === this.edited ? model.shown : latticeOf(state)]));
  }

  get steps(): UndoSteps {
    return this.stepsFor(this.edited);
  }

  /** Undefined before the first lattice. */
  get shown(): Lattice | undefined {
    return this.model?.shown;
  }

  /** As EditQueue.refuseFolds. */
  set refuseFolds(on: boolean) {
    this.queue.refuseFolds = on;
  }

  get constraints(): Constraints {
    return this.kept;
  }

  /** The control points that no edit moves. */
  get held(): ReadonlySet<number> {
    return this.keptStill;
  }

  gesture(owner: GestureListener = {}): Gesture {
    this.openGesture?.giveWay();
    this.openGesture = new OwnGesture(this.queue, this.model!, (targets) => this.show(targets), owner);
    return this.openGesture;
  }

  /** One edit that is an undo step of its own. `targets` are shown at once. */
  step(edit: Edit, targets?: Targets, answered?: OnAnswer): void {
    this.openGesture?.giveWay();
    this.queue.add({ edits: [edit], targets, answered }, this.model!.structureId);
    if (targets) this.show(targets);
  }

  /** Adds a lattice, and shows it when the server has taken it. */
  add(lattice: Lattice): void {
    this.openGesture?.giveWay();
    this.queue.add({ edits: [edits.replaceLattice(lattice, false)], lattice: this.states.free }, this.model!.structureId);
  }

  get canUndo(): boolean {
    return this.steps.canUndo || this.removals.toUndo(false) !== undefined;
  }

  /**
   * Reverts this window's last step of the lattice that is shown; its last removal of one, which is then shown; or weights that it
   * has set while lattice 0 was away.
   */
  undo(): void {
    this.stepOf(this.removals.toUndo(this.steps.canUndo), edits.undo());
  }

  get canRedo(): boolean {
    return this.steps.canRedo || this.removals.toRedo(false) !== undefined;
  }

  /** Makes this window's last undone step again, as undo: of the lattice that is shown, the addition of one, or weights. */
  redo(): void {
    this.stepOf(this.removals.toRedo(this.steps.canRedo), edits.redo());
  }

  /** An edit of a lattice that may not be there; undefined: of the one that is shown. */
  private stepOf(lattice: number | undefined, edit: Edit): void {
    if (lattice === undefined) return this.step(edit);
    this.openGesture?.giveWay();
    this.queue.add({ edits: [edit], lattice }, this.model!.structureId);
  }

  takeState(state: LatticeState): void {
    this.states.take(state);
    this.removals.settle();
    if (!this.model && !this.states.has(this.edited)) this.edited = this.wanted = state.indexes[0] ?? state.index;
    if (this.model && !this.states.of(this.edited)) this.leave(state.structureId);
    if (state.index === this.edited) this.showState(state);
    this.turn();
  }

  /** The lattice that is shown was removed: the first one that is left is shown once no edit waits for its answer. */
  private leave(structureId: bigint): void {
    this.queue.reached(this.states.revision);
    if (!this.states.of(this.wanted)) this.wanted = this.states.numbers[0]!;
    this.letGo(structureId);
  }

  private stepsFor(lattice: number): UndoSteps {
    return (this.stepsOf[lattice] ??= new UndoSteps());
  }

  private turn(): void {
    const state = this.states.of(this.wanted);
    if (this.wanted === this.edited || this.queue.isPending || !state) return;
    this.edited = this.wanted;
    this.model = undefined;
    this.showState(state);
  }

  private showState(state: LatticeState): void {
    const lattice = latticeOf(state);
    const first = !this.model;
    const known = this.model?.structureId;
    this.model ??= new LatticeModel(lattice, state.structureId, state.revision, this.queue);
    const changed = this.model.takeState(lattice, state.structureId, state.revision);
    this.queue.reached(state.revision);
    if (first || changed) this.structureSince = state.revision;
    if (changed) this.letGo(state.structureId === known ? undefined : state.structureId);
    const moved = this.model.refresh();
    if (first || changed) this.listeners.emit('lattice', this.model.shown);
    else this.pointsMoved(moved);
    this.kept = toConstraints(state.constraints);
    this.keptStill = heldPoints(lattice.size, this.kept);
    this.listeners.emit('constraints');
  }

  takeDelta(delta: LatticeDelta): void {
    const isTaken = this.states.takeDelta(delta);
    this.removals.settle();
    if (delta.lattice !== this.edited) {
      this.queue.reached(delta.revision);
      return this.turn();
    }
    if (!this.model || !isTaken || delta.structureId !== this.model.structureId) return;
    const { strength } = delta;
    const targets = {
      indices: Uint32Array.from(delta.indices), positions: Float64Array.from(delta.positions),
      ...(strength !== undefined && { strength }),
    };
    this.model.takeDelta(targets, delta.revision);
    this.queue.reached(delta.revision);
    this.pointsMoved(this.model.refresh(targets.indices));
    this.turn();
  }

  takeResult(result: EditResult): void {
    // A server that ends the stream did not take the edit. It stays in flight, and the next server gets it.
    if (['DRAINING', 'SCENE_MOVED'].includes(result.status ? ServerError.fromStatus(result.status).reason : '')) return;
    const { refused, message, targets, gestureId, onAnswer } = this.queue.answer(result);
    if (this.model) this.queue.reached(this.states.of(this.edited) ? this.model.revision : this.states.revision);
    if (!refused && gestureId) this.openGesture?.answered(gestureId, result.dragResidual);
    if (!refused) {
      if (message) this.stepsFor(message.lattice).applied(message);
      const isOfWeights = message && this.removals.applied(message, result.revision);
      if (message && !isOfWeights && isAdded(message, this.edited)) this.wanted = message.lattice;
      if (keepsShape(message)) this.listeners.emit('refitted', result.dragResidual);
      this.turn();
      this.listeners.emit('answered');
      return onAnswer?.(undefined);
    }
    if (targets) this.pointsMoved(this.model!.refresh(targets.indices));
    const error = ServerError.fromStatus(result.status!);
    this.stepsFor(message!.lattice).refused(error.reason);
    this.removals.refused(message!, error.reason);
    if (error.reason === 'FOLD') this.endAtLastGood(message!);
    this.turn();
    this.listeners.emit('answered');
    const words = inWords(error);
    this.listeners.emit('refused', words, /^(NOTHING_TO_.*|FOLD)$/.test(error.reason));
    onAnswer?.(words);
  }

  /** A gesture whose last batch would have folded ends at the one before. */
  private endAtLastGood({ gestureId, gesturePhase, edits, structureId }: EditBatch): void {
    if (gesturePhase !== GesturePhase.COMMIT || !edits.length) return;
    this.queue.add({ edits: [], gestureId, phase: GesturePhase.COMMIT }, structureId);
  }

  /** Whether the lattice that is shown is the server's at this revision. */
  isAt(revision: bigint): boolean {
    return this.model !== undefined && !this.queue.isPending && this.model.revision <= revision;
  }

  /** Whether all lattices in `numbered` are the server's at this revision. */
  areAt(revision: bigint): boolean {
    return this.isAt(revision) && this.states.revision <= revision;
  }

  /** Whether the scene still has the lattice that is shown: one that is gone stays until no edit waits for its answer. */
  get isThere(): boolean {
    return this.states.has(this.edited);
  }

  /**
   * The structure that the lattice has at this revision, whose state has come; undefined if it has another one since. Once the
   * lattice is gone: of the only one that is left, if it is so; surfaces of several are of their sum.
   */
  structureAt(revision: bigint): LatticeStructure | undefined {
    if (this.model && !this.isThere) {
      const [left, ...others] = this.states.all;
      return left && !others.length && left.revision <= revision ? toLattice(left.lattice!) : undefined;
    }
    return revision >= this.structureSince ? this.model?.shown : undefined;
  }

  /** Milliseconds since the newest sent edit up to `sequence`; undefined if an earlier call has reported it. */
  ageOf(sequence: bigint): number | undefined {
    return this.queue.ageOf(sequence);
  }

  /**
   * A stream is open, and the server's lattice is at `head`: the batch in flight is sent again. If revisions have gone
   * back, somebody has made another scene under the same id, on a server that had lost this one. It takes no edits that
   * were made for the other.
   */
  opened(head: bigint): void {
    if (this.model && head < this.model.revision) {
      for (const steps of this.stepsOf) steps?.forget();
      this.states.forget();
      this.removals.forget();
      this.edited = this.wanted = 0;
      const unsent = this.queue.clear();
      if (this.openGesture?.abandon() || unsent) this.listeners.emit('refused', LatticeSync.MADE_AGAIN);
    }
    this.queue.opened();
  }

  lost(): void {
    this.queue.lost();
  }

  /** Ends the gesture, and drops edits for other structures than this; for all if absent, as an id may return. */
  private letGo(structureId?: bigint): void {
    const ended = this.openGesture?.abandon();
    if (this.queue.dropOther(structureId)) this.listeners.emit('refused', LatticeSync.DROPPED);
    else if (ended) this.listeners.emit('refused', LatticeSync.CHANGED);
  }

  private show(targets: Targets): void {
    this.model!.show(targets);
    const all = targets.strength !== undefined; // of the surface
    this.pointsMoved(all ? Uint32Array.from(indicesTo(this.model!.shown.count)) : targets.indices, true);
  }

  private pointsMoved(indices: Uint32Array, isOwn = false): void {
    if (indices.length) this.listeners.emit('points', indices, isOwn);
  }
}

function latticeOf(state: LatticeState): Lattice {
  const lattice = toLattice(state.lattice!);
  lattice.strength = state.strength ?? 1;
  return lattice;
}

/** Whether a batch that is not of weights has added a lattice, or given one back. All others are of the lattice that is shown. */
function isAdded({ edits, lattice }: EditBatch, shown: number): boolean {
  return lattice !== shown && ['replaceLattice', 'undo', 'redo'].includes(edits[0]?.edit.case ?? '');
}

function keepsShape(batch: EditBatch | undefined): boolean {
  const edit = batch?.edits[0]?.edit;
  return edit?.case === 'replaceLattice' && edit.value.keepShape;
}

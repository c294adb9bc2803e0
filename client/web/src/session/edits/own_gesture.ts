// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { GesturePhase } from 'latticed/v1/edit_pb';
import { fromEdit } from '../../wire/edit_message';
import { randomId } from '../../wire/ids';
import type { EditQueue, NewBatch } from './edit_queue';
import { targetsOf, withRestored, type Targets } from './edit_targets';
import type { LatticeEdit } from './lattice_edit';
import type { LatticeModel } from './lattice_model';
import type { Gesture, GestureListener } from '../scene_session';

/** A gesture of this window. Its edits apply to the points at its begin, as on the server, so errors do not add up. */
export class OwnGesture implements Gesture {
  private readonly id = randomId();
  private readonly structureId: bigint;  // of the lattice at the gesture's begin
  private start: Float64Array | undefined;
  private startStrength: number | undefined;  // if the gesture has set another one
  private readonly touched = new Set<number>();
  private begun = false;  // a batch was queued
  private ended = false;

  constructor(
    private readonly queue: EditQueue,
    private readonly model: LatticeModel,
    private readonly show: (targets: Targets) => void,
    private readonly owner: GestureListener,
  ) {
    this.structureId = model.structureId;
  }

  get isOpen(): boolean {
    return !this.ended && this.model.structureId === this.structureId;
  }

  update(edit: LatticeEdit): void {
    if (this.isOpen) this.add(edit, GesturePhase.UPDATE);
  }

  commit(edit?: LatticeEdit): void {
    if (!this.isOpen) return;
    if (edit) {
      this.add(edit, GesturePhase.COMMIT);
    } else if (this.begun) {
      const last: NewBatch = this.queue.takeBack(this.id) ?? { edits: [] };
      this.queue.add({ ...last, gestureId: this.id, phase: GesturePhase.COMMIT }, this.structureId);
    }
    this.ended = true;
  }

  cancel(): void {
    if (!this.isOpen) return;
    this.ended = true;
    if (!this.begun) return;
    this.queue.takeBack(this.id);
    const start = this.start!;
    const nothing = { indices: new Uint32Array(), positions: new Float64Array() };
    const targets = withRestored(this.withStrength(nothing), this.touched, start);
    if (this.queue.hasSent(this.id)) {
      this.queue.add({ edits: [], targets, gestureId: this.id, phase: GesturePhase.CANCEL }, this.structureId);
    }
    this.show(targets);
  }

  /** Commits the gesture for the session and notifies its owner. Returns whether it was open. */
  giveWay(): boolean {
    if (!this.isOpen) return false;
    this.commit();
    this.owner.ended?.();
    return true;
  }

  /** Ends the gesture without telling the server. Moved points stay. Returns whether it had not ended before. */
  abandon(): boolean {
    if (this.ended) return false;
    this.ended = true;
    this.owner.ended?.();
    return true;
  }

  /** The server has applied a batch of the gesture `gestureId`. */
  answered(gestureId: string, dragResidual: number): void {
    if (gestureId === this.id && this.isOpen) this.owner.dragged?.(dragResidual);
  }

  /** Where an edit sets none, the strength is that at the gesture's begin. */
  private withStrength(targets: Targets): Targets {
    return this.startStrength === undefined ? targets : { strength: this.startStrength, ...targets };
  }

  private add(edit: LatticeEdit, phase: GesturePhase): void {
    this.start ??= this.model.shown.points.slice();
    const moved = targetsOf(edit, this.start);
    const targets = moved && withRestored(this.withStrength(moved), this.touched, this.start);
    if (edit.kind === 'strength') this.startStrength ??= this.model.shown.strength;
    for (const index of moved?.indices ?? []) this.touched.add(index);
    this.begun = true;
    this.queue.add({ edits: [fromEdit(edit)], targets, gestureId: this.id, phase }, this.structureId, true);
    if (targets) this.show(targets);
  }
}

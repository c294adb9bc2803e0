// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { EditBatchSchema, type Edit, type EditBatch, type EditResult, type GesturePhase } from 'latticed/v1/edit_pb';
import type { Targets } from './edit_targets';

/** The content of one EditBatch. */
export interface NewBatch {
  readonly edits: readonly Edit[];
  readonly targets?: Targets | undefined;
  readonly gestureId?: string;
  readonly phase?: GesturePhase;
  /** The number of its lattice. Absent: the sender fills in the shown one. */
  readonly lattice?: number;
  readonly answered?: OnAnswer | undefined;
}

/** Called with the server's answer to one batch: why it was refused, in words, or undefined. Never if the batch is dropped. */
export type OnAnswer = (refusal: string | undefined) => void;

interface Batch {
  readonly message: EditBatch;
  readonly targets: Targets | undefined;
  /** Whether the message's lattice is the batch's; else the sender fills in the shown one. */
  readonly namesLattice: boolean;
  readonly onAnswer: OnAnswer | undefined;
  /** performance.now() of the edit. */
  readonly madeAt: number;
  /** The revision that the answer names; absent before the answer. */
  revision?: bigint;
}

/** The batch that an answer is for. */
export interface Answered {
  readonly refused: boolean;
  /** Absent if the answer is for none in flight. */
  readonly message?: EditBatch;
  readonly targets?: Targets | undefined;
  /** Empty for an edit outside a gesture. */
  readonly gestureId?: string;
  readonly onAnswer?: OnAnswer | undefined;
}

/**
 * This window's edits, to be sent to the server. At most one is in flight, and only the newest update of a gesture
 * waits. After a lost connection the edit in flight is sent again with its number; the server applies it once.
 */
export class EditQueue {
  /** Whether the server is to refuse batches that make a new fold. Counts for batches that are added from now on. */
  refuseFolds = false;
  private readonly answered: Batch[] = [];  // applied, but the server's lattice here does not hold them yet
  private inFlight: Batch | undefined;
  private readonly waiting: Batch[] = [];
  private readonly sent: { readonly sequence: bigint; readonly madeAt: number }[] = [];
  private nextSequence = 1n;
  private isOpen = false;
  private sentGesture = '';  // of the batch sent last

  /**
   * @param send Sends one batch.
   * @param now The time in milliseconds.
   */
  constructor(private readonly send: (batch: EditBatch, namesLattice: boolean) => void, private readonly now: () => number = () => performance.now()) {}

  /** The targets of edits to one structure that the server's lattice here may lack, oldest first. */
  overlays(structureId: bigint): readonly Targets[] {
    return [...this.answered, ...this.unansweredBatches]
      .flatMap(({ message, targets }) => (targets && message.structureId === structureId ? [targets] : []));
  }

  /** Batches without an answer. */
  get unanswered(): number {
    return this.unansweredBatches.length;
  }

  /** Whether the server's lattice here may lack edits of this window. */
  get isPending(): boolean {
    return this.answered.length + this.unanswered > 0;
  }

  /** Adds a batch. With `replace` it takes the place of the gesture's newest batch, if that still waits. */
  add(batch: NewBatch, structureId: bigint, replace = false): void {
    const last = this.waiting.at(-1);
    if (replace && last && last.message.gestureId === batch.gestureId) this.waiting.pop();
    this.waiting.push(this.made(batch, structureId));
    this.pump();
  }

  /** The newest batch of a gesture, taken out of the queue if it still waits there. */
  takeBack(gestureId: string): NewBatch | undefined {
    const last = this.waiting.at(-1);
    if (last?.message.gestureId !== gestureId) return undefined;
    this.waiting.pop();
    return { edits: last.message.edits, targets: last.targets, gestureId };
  }

  /** Whether the last batch sent is of this gesture, so that the server may know of it. */
  hasSent(gestureId: string): boolean {
    return this.sentGesture === gestureId;
  }

  /** A stream is open: the batch in flight is sent again. */
  opened(): void {
    this.isOpen = true;
    if (this.inFlight) this.send(this.inFlight.message, this.inFlight.namesLattice);
    this.pump();
  }

  lost(): void {
    this.isOpen = false;
  }

  /** Takes an answer. Returns the targets to take back if the batch was refused, else the gesture's id. */
  answer(result: EditResult): Answered {
    const batch = this.inFlight;
    if (!batch || batch.message.sequence !== result.sequence) return { refused: false };
    this.inFlight = undefined;
    const refused = Boolean(result.status && result.status.code !== 0);
    if (!refused) {
      batch.revision = result.revision;
      this.answered.push(batch);
    }
    this.pump();
    const { message, targets, onAnswer } = batch;
    return refused ? { refused, message, targets, onAnswer } : { refused, message, gestureId: message.gestureId, onAnswer };
  }

  /** The server's lattice here is at `revision`: answered edits up to this revision are in it. */
  reached(revision: bigint): void {
    while (this.answered[0] && this.answered[0].revision! <= revision) this.answered.shift();
  }

  /** Drops waiting batches for other structures, or all if `structureId` is absent. Returns how many. */
  dropOther(structureId?: bigint): number {
    const dropped = this.waiting.filter(({ message }) => message.structureId !== structureId);
    const kept = this.waiting.filter(({ message }) => message.structureId === structureId);
    this.waiting.splice(0, this.waiting.length, ...kept);
    return dropped.length;
  }

  /** Drops everything. Returns whether any of it had no answer. */
  clear(): boolean {
    const unanswered = this.unanswered > 0;
    this.answered.length = this.waiting.length = this.sent.length = 0;
    this.inFlight = undefined;
    return unanswered;
  }

  /** Milliseconds since the newest sent edit up to `sequence`; undefined if an earlier call has reported it. */
  ageOf(sequence: bigint): number | undefined {
    let newest: number | undefined;
    while (this.sent[0] && this.sent[0].sequence <= sequence) newest = this.sent.shift()!.madeAt;
    return newest === undefined ? undefined : this.now() - newest;
  }

  private get unansweredBatches(): readonly Batch[] {
    return [...(this.inFlight ? [this.inFlight] : []), ...this.waiting];
  }

  /** A batch without a sequence number, which it gets when it is sent. */
  private made({ edits, targets, gestureId, phase, lattice, answered }: NewBatch, structureId: bigint): Batch {
    const message = create(EditBatchSchema, {
      structureId, edits: [...edits], refuseFolds: this.refuseFolds,
      ...(gestureId && { gestureId }), ...(phase && { gesturePhase: phase }), ...(lattice && { lattice }),
    });
    return { targets, namesLattice: lattice !== undefined, onAnswer: answered, madeAt: this.now(), message };
  }

  private pump(): void {
    if (!this.isOpen || this.inFlight || !this.waiting.length) return;
    this.inFlight = this.waiting.shift()!;
    this.inFlight.message.sequence = this.nextSequence++;
    this.sentGesture = this.inFlight.message.gestureId;
    this.sent.push({ sequence: this.inFlight.message.sequence, madeAt: this.inFlight.madeAt });
    this.send(this.inFlight.message, this.inFlight.namesLattice);
  }
}

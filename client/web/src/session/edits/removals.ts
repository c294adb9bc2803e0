// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { EditBatch } from 'latticed/v1/edit_pb';
import type { LatticeStates } from './lattice_states';

interface Step {
  readonly lattice: number;
  /** The scene's, with the step. */
  readonly revision: bigint;
}

/**
 * Which lattices that the scene does not have hold steps of this window, by the server's answers. It has taken them away by a
 * removal, its redo, or the undo of an addition; and weights have the history of lattice 0, even where that is away. Undo or redo
 * goes to their numbers. A lattice that somebody gives back is an ordinary one again.
 */
export class Removals {
  private removed: readonly Step[] = []; // the last one is the newest
  private undone: Step | undefined; // what this window's last step has undone: the addition of a lattice, or weights
  private newest: number | undefined; // the lattice that has this window's newest step, if it is away
  private painted = 0; // steps of this window that have set weights while lattice 0 was away
  private unpainted = 0; // those of them that were undone since
  private awaited: { readonly kind: string | undefined; readonly step: Step } | undefined; // whether it took its lattice away

  constructor(private readonly states: LatticeStates) {}

  /** The lattice that undo goes to. `canUndo`: whether the lattice that is shown has steps to undo. */
  toUndo(canUndo: boolean): number | undefined {
    if (this.newest !== undefined || canUndo) return this.newest;
    return this.painted > 0 ? 0 : this.removed.at(-1)?.lattice;
  }

  /** The lattice that redo goes to. `canRedo`: as for undo. */
  toRedo(canRedo: boolean): number | undefined {
    if (this.undone || canRedo) return this.undone?.lattice;
    return this.unpainted > 0 && this.isAway(0) ? 0 : undefined;
  }

  /** The server has applied a batch, at this revision. Returns whether it set weights while lattice 0 was away, or undid that. */
  applied({ edits: [first], lattice }: EditBatch, revision: bigint): boolean {
    const kind = first?.edit.case;
    const step = { lattice, revision };
    const givesBack = (kind === 'undo' && this.isRemoved(lattice)) || (kind === 'redo' && this.undone?.lattice === lattice);
    const setsWeights = lattice === 0 && this.isAway(0)
      && (kind === 'setWeights' || (kind === 'undo' && this.painted > 0) || (kind === 'redo' && this.unpainted > 0));
    this.awaited = this.undone = this.newest = undefined;
    if (setsWeights) {
      this.painted += kind === 'undo' ? -1 : 1;
      this.unpainted = kind === 'setWeights' ? 0 : this.unpainted + (kind === 'undo' ? 1 : -1);
      if (this.painted > 0 || this.isRemoved(0)) this.newest = 0;
      if (this.unpainted > 0) this.undone = step;
      return true;
    }
    if (lattice === 0 && kind !== 'undo' && kind !== 'redo') this.unpainted = 0;
    this.drop(lattice);
    if (kind === 'removeLattice') this.gone(kind, step);
    else if (!givesBack) this.awaited = { kind, step };
    this.settle();
    return false;
  }

  /** The server has refused a batch: its history has no such step. */
  refused({ lattice }: EditBatch, reason: string): void {
    if (reason === 'NOTHING_TO_UNDO') this.drop(lattice);
    if (reason === 'NOTHING_TO_REDO' && this.undone?.lattice === lattice) this.undone = undefined;
    if (reason === 'NOTHING_TO_REDO' && lattice === 0) this.unpainted = 0;
  }

  /** Newer states have come. */
  settle(): void {
    const { awaited, states } = this;
    if (awaited && awaited.step.revision <= states.revision) {
      this.awaited = undefined;
      if (!states.has(awaited.step.lattice)) this.gone(awaited.kind, awaited.step);
    }
    const isBack = ({ lattice, revision }: Step): boolean => revision <= states.revision && states.has(lattice);
    for (const step of this.removed) if (isBack(step)) this.drop(step.lattice);
    if (this.undone && isBack(this.undone)) this.undone = undefined;
    if (this.painted > 0 && !this.isAway(0)) this.drop(0);
  }

  /** The scene has another history. */
  forget(): void {
    this.removed = [];
    this.undone = this.newest = this.awaited = undefined;
    this.painted = this.unpainted = 0;
  }

  /** A step of this window took its lattice away. */
  private gone(kind: string | undefined, step: Step): void {
    if (kind === 'undo') this.undone = step;
    if (kind !== 'removeLattice' && kind !== 'redo') return;
    this.removed = [...this.removed, step];
    this.newest = step.lattice;
  }

  private isRemoved(lattice: number): boolean {
    return this.removed.some((step) => step.lattice === lattice);
  }

  private isAway(lattice: number): boolean {
    return this.isRemoved(lattice) || !this.states.has(lattice);
  }

  private drop(lattice: number): void {
    this.removed = this.removed.filter((step) => step.lattice !== lattice);
    if (this.newest === lattice) this.newest = undefined;
    if (lattice === 0) this.painted = 0;
  }
}

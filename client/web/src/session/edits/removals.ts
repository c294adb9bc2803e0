// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { EditBatch } from 'latticed/v1/edit_pb';

/**
 * The lattices that this window has taken away, by the server's answers: by a removal, its redo, or the undo of an addition.
 * Undo or redo with its number gives one back.
 */
export class Removals {
  private removed: readonly number[] = []; // the last one is the newest
  private isNewest = false; // this window has made no step since the last removal
  private undone: number | undefined; // the lattice whose addition this window's last step has undone
  private last: { readonly kind: string | undefined; readonly lattice: number } | undefined; // of this window's steps

  /** The lattice that undo gives back. `canUndo`: whether the lattice that is shown has steps to undo. */
  toUndo(canUndo: boolean): number | undefined {
    return this.isNewest || !canUndo ? this.removed.at(-1) : undefined;
  }

  /** The lattice that redo gives back. */
  get toRedo(): number | undefined {
    return this.undone;
  }

  /** The server has applied a batch. `isThere`: whether its lattice is still known. */
  applied({ edits: [first], lattice }: EditBatch, isThere: boolean): void {
    const kind = first?.edit.case;
    const givesBack = (kind === 'undo' && this.removed.includes(lattice)) || (kind === 'redo' && this.undone === lattice);
    this.last = givesBack ? undefined : { kind, lattice };
    this.removed = this.removed.filter((number) => number !== lattice);
    this.isNewest = false;
    this.undone = undefined;
    if (kind === 'removeLattice' || !isThere) this.gone(lattice);
  }

  /** The scene does not have this lattice any more. */
  gone(lattice: number): void {
    if (this.last?.lattice !== lattice) return; // somebody else's removal
    if (this.last.kind === 'undo') this.undone = lattice;
    if (this.last.kind !== 'removeLattice' && this.last.kind !== 'redo') return;
    this.removed = [...this.removed.filter((number) => number !== lattice), lattice];
    this.isNewest = true;
  }

  /** The scene has another history. */
  forget(): void {
    this.removed = [];
    this.undone = this.last = undefined;
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { EditBatch } from 'latticed/v1/edit_pb';

/** The lattices that this window has removed, by the server's answers. Undo with its number gives one back. */
export class Removals {
  private numbers: readonly number[] = []; // the last one removed is the last
  private isNewest = false; // this window has made no step since the last removal
  private redone: number | undefined; // the lattice of this window's last step, if that was a redo

  /** The lattice that undo gives back, if `canUndo` says whether there are other steps to undo first. */
  toUndo(canUndo: boolean): number | undefined {
    return this.isNewest || !canUndo ? this.numbers.at(-1) : undefined;
  }

  /** The server has applied a batch. `isThere`: whether its lattice is still known. */
  applied({ edits: [first], lattice }: EditBatch, isThere: boolean): void {
    const kind = first?.edit.case;
    this.redone = kind === 'redo' ? lattice : undefined;
    this.numbers = this.numbers.filter((number) => number !== lattice);
    this.isNewest = false;
    if (kind === 'removeLattice' || (kind === 'redo' && !isThere)) this.add(lattice);
  }

  /** The scene does not have this lattice any more. */
  gone(lattice: number): void {
    if (this.redone === lattice) this.add(lattice);
  }

  /** The scene has another history. */
  forget(): void {
    this.numbers = [];
    this.redone = undefined;
  }

  private add(lattice: number): void {
    this.numbers = [...this.numbers.filter((number) => number !== lattice), lattice];
    this.isNewest = true;
  }
}

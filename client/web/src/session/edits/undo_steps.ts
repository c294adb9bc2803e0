// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { GesturePhase, type EditBatch } from 'latticed/v1/edit_pb';

/** How many steps of this window the server's history holds to undo and to redo, by its answers. */
export class UndoSteps {
  private toUndo = 0;
  private toRedo = 0;

  get canUndo(): boolean {
    return this.toUndo > 0;
  }

  get canRedo(): boolean {
    return this.toRedo > 0;
  }

  applied({ edits: [first], gestureId, gesturePhase }: EditBatch): void {
    const kind = first?.edit.case;
    if (kind === 'undo') this.move(-1);
    else if (kind === 'redo') this.move(1);
    else {
      if (kind !== undefined) this.toRedo = 0; // also by edits of a gesture that is cancelled later
      if (gestureId === '' || gesturePhase === GesturePhase.COMMIT) ++this.toUndo;
    }
  }

  /** The server has forgotten the oldest steps. */
  refused(reason: string): void {
    if (reason === 'NOTHING_TO_UNDO') this.toUndo = 0;
    if (reason === 'NOTHING_TO_REDO') this.toRedo = 0;
  }

  /** The scene has another history. */
  forget(): void {
    this.toUndo = this.toRedo = 0;
  }

  private move(by: 1 | -1): void {
    this.toUndo = Math.max(this.toUndo + by, 0);
    this.toRedo = Math.max(this.toRedo - by, 0);
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Between two choices of levels while the camera moves, and after the last motion or edit until rest. */
export const PAUSE_MS = 150;

export interface LevelChoice {
  /** Levels are to be chosen anew, by the tolerance as it is now. */
  readonly isDue: boolean;
  /** The camera moves: levels that are finer than needed by one may stay. */
  readonly isLazy: boolean;
}

/** When levels are chosen anew: at once as edits begin and end, now and then while the camera moves, and once it rests. */
export class LevelPace {
  private chosen = { tolerance: '', isEditing: false, at: -Infinity };
  private wasLazy = false;

  /**
   * A frame is drawn.
   *
   * @param tolerance What levels follow from; only whether it is the same counts.
   * @param isEditing Whether control points have moved a moment ago.
   * @param now In milliseconds.
   */
  frame(tolerance: string, isEditing: boolean, now: number): LevelChoice {
    const { chosen, wasLazy } = this;
    const isOther = tolerance !== chosen.tolerance;
    const isLazy = isOther && isEditing === chosen.isEditing; // else an edit has begun or ended
    const isDue = isOther ? !isLazy || now - chosen.at >= PAUSE_MS : wasLazy; // at rest, levels are those of the camera alone
    if (isOther && isDue) this.chosen = { tolerance, isEditing, at: now };
    this.wasLazy = isLazy;
    return { isDue, isLazy };
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Follows a session's lattice with the server's report of folds: at most one question at a time, and some per second while the
// lattice moves. Whoever moved it, the report is about the server's newest revision.
import type { LiveSession } from './session/live_session';
import type { Folds } from './wire/fold_message';

const PAUSE_MS = 100;

export class FoldsWatch {
  private timer: ReturnType<typeof setTimeout> | undefined;
  private asking = false;
  private again = false;
  private ended = false;
  private lattices = 0;  // how many there were: an answer may be about the one before
  private readonly ends: readonly (() => void)[];

  /** @param show Called with each new report; undefined while nothing is known. */
  constructor(
    private readonly session: Pick<LiveSession, 'on' | 'certifyFolds'>,
    private readonly show: (folds: Folds | undefined) => void,
    private readonly pauseMs = PAUSE_MS,
  ) {
    const soon = (): void => this.askSoon();
    this.ends = [
      session.on('points', soon),
      session.on('answered', soon),
      session.on('lattice', () => {
        ++this.lattices;
        this.show(undefined); // the boxes are others
        this.askSoon();
      }),
      session.on('status', ({ state }) => state === 'live' && this.askSoon()),
    ];
    this.askSoon();
  }

  dispose(): void {
    this.ended = true;
    clearTimeout(this.timer);
    for (const end of this.ends) end();
  }

  private askSoon(): void {
    if (this.asking) this.again = true;
    else if (!this.ended) this.timer ??= setTimeout(() => void this.ask(), this.pauseMs);
  }

  private async ask(): Promise<void> {
    this.timer = undefined;
    [this.asking, this.again] = [true, false];
    const { lattices } = this;
    // Without an answer the next change, or the next connection, asks again.
    const folds = await this.session.certifyFolds().catch(() => undefined);
    this.asking = false;
    if (this.ended) return;
    if (lattices === this.lattices) this.show(folds);
    if (this.again) this.askSoon();
  }
}

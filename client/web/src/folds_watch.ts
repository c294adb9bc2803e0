// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Follows a session's lattice with the server's report of folds. Whoever moved the lattice, the report is about the server's
// newest revision.
import { RepeatedCall } from './repeated_call';
import type { LiveSession } from './session/live_session';
import type { Folds } from './wire/fold_message';

const PAUSE_MS = 100;

export class FoldsWatch {
  private readonly report: RepeatedCall;
  private lattices = 0;  // how many there were: an answer may be about the one before
  private readonly ends: readonly (() => void)[];

  /** @param show Called with each new report; undefined while nothing is known. */
  constructor(
    private readonly session: Pick<LiveSession, 'on' | 'certifyFolds'>,
    private readonly show: (folds: Folds | undefined) => void,
    pauseMs = PAUSE_MS,
  ) {
    this.report = new RepeatedCall(() => this.ask(), pauseMs);
    const soon = (): void => this.report.soon();
    this.ends = [
      session.on('points', soon),
      session.on('answered', soon),
      session.on('lattice', () => {
        ++this.lattices;
        this.show(undefined); // the boxes are others
        soon();
      }),
      session.on('status', ({ state }) => state === 'live' && soon()),
    ];
    soon();
  }

  dispose(): void {
    this.report.end();
    for (const end of this.ends) end();
  }

  private async ask(): Promise<void> {
    const { lattices } = this;
    // Without an answer the next change, or the next connection, asks again.
    const folds = await this.session.certifyFolds().catch(() => undefined);
    if (!this.report.ended && lattices === this.lattices) this.show(folds);
  }
}

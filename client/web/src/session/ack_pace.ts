// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/**
 * Decides which update is acknowledged when one has been taken in. The server sends at most AT_ONCE updates without an
 * acknowledgement, so it sends the next one while this one is decoded. If an update replaces one that nobody has seen, this
 * page is too slow: for a while updates go one at a time, each acknowledged with the one after it.
 */
export class AckPace {
  static readonly AT_ONCE = 2;
  /** Updates until two at once are tried again. A reader that stays slow decodes one update in 33 for nothing. */
  static readonly ALONE = 32;

  private takenIn = 0n; // the newest
  private alone = 0; // updates that still go one at a time

  /** A stream is open, whose updates are numbered from 1. */
  opened(): void {
    this.takenIn = 0n;
    this.alone = 0;
  }

  /** An update was taken in, in which `unseen` has gone up, if any; returns what is acknowledged. */
  take(updateId: bigint, unseen: bigint | undefined): bigint {
    const before = unseen ?? this.takenIn;
    this.takenIn = updateId;
    if (unseen !== undefined) this.alone = AckPace.ALONE;
    else if (this.alone > 0) --this.alone;
    return this.alone > 0 ? before : updateId;
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/**
 * Decides which update is acknowledged when one has been taken in. The server sends at most AT_ONCE updates without an
 * acknowledgement, so it sends the next one while this one is decoded. If an update replaces one that nobody has seen,
 * this page is too slow. Then updates go one at a time for a while: each is acknowledged with the one after it.
 */
export class AckPace {
  static readonly AT_ONCE = 2;
  /** Updates until two at once are tried again. A reader that stays slow decodes one update in 33 in vain. */
  static readonly ALONE = 32;

  private takenIn = 0n; // the newest update
  private alone = 0; // updates that still go one at a time

  /** A stream is open. It numbers its updates from 1. */
  opened(): void {
    this.takenIn = 0n;
    this.alone = 0;
  }

  /** An update was taken in; `unseen` is the newest update merged into it, if any. Returns the one to acknowledge. */
  take(updateId: bigint, unseen: bigint | undefined): bigint {
    const before = unseen ?? this.takenIn;
    this.takenIn = updateId;
    if (unseen !== undefined) this.alone = AckPace.ALONE;
    else if (this.alone > 0) --this.alone;
    return this.alone > 0 ? before : updateId;
  }
}

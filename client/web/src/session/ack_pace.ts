// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/**
 * Which update is acknowledged when one is taken in, where the server begins no more than AT_ONCE without: so that it sends
 * the next one while this one is decoded. Where that one comes before its time, so that it takes the place of one that
 * nobody has seen, they go one at a time for a while: the newest is acknowledged with the one after it.
 */
export class AckPace {
  static readonly AT_ONCE = 2;
  /** So many updates go by before two at once are tried again: a reader that is slow for long gets one in 33 in vain. */
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

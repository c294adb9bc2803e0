// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes a call again and again while what it asks about changes: one at a time, each a pause after the change.
export class RepeatedCall {
  private timer: ReturnType<typeof setTimeout> | undefined;
  private isCalling = false;
  private isStale = false;
  private hasEnded = false;

  /** @param call Handles its own errors. */
  constructor(private readonly call: () => Promise<void>, private readonly pauseMs: number) {}

  get ended(): boolean {
    return this.hasEnded;
  }

  soon(): void {
    this.isStale = true;
    if (!this.isCalling && !this.hasEnded) this.timer ??= setTimeout(() => void this.make(), this.pauseMs);
  }

  end(): void {
    this.hasEnded = true;
    clearTimeout(this.timer);
  }

  private async make(): Promise<void> {
    this.timer = undefined;
    [this.isCalling, this.isStale] = [true, false];
    await this.call();
    this.isCalling = false;
    if (this.isStale) this.soon();
  }
}

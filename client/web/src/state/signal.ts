// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Calls the listeners of one kind of event. */
export class Signal<Args extends unknown[] = []> {
  private readonly listeners = new Set<(...args: Args) => void>();

  /** Returns a function that removes the listener. */
  readonly on = (listener: (...args: Args) => void): (() => void) => {
    this.listeners.add(listener);
    return () => void this.listeners.delete(listener);
  };

  emit(...args: Args): void {
    for (const listener of [...this.listeners]) listener(...args);
  }
}

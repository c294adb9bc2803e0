// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** A record that tells of its changes. */
export class Store<T extends object> {
  private listeners = new Set<(value: Readonly<T>, before: Readonly<T>) => void>();

  constructor(private current: T) {}

  get value(): Readonly<T> {
    return this.current;
  }

  /** Replaces the fields named; listeners hear of it where one of them is another. */
  set(change: Partial<T>): void {
    const before = this.current;
    const keys = Object.keys(change) as (keyof T)[];
    if (keys.every((key) => Object.is(before[key], change[key]))) return;
    this.current = { ...before, ...change };
    for (const listener of this.listeners) listener(this.current, before);
  }

  /** Calls `listener` after every change; the function returned ends that. */
  subscribe(listener: (value: Readonly<T>, before: Readonly<T>) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}

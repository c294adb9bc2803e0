// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

import { Signal } from './signal';

/** A record that reports its changes. */
export class Store<T extends object> {
  private readonly changed = new Signal<[value: Readonly<T>, before: Readonly<T>]>();
  /** Calls a listener after every change; the function returned removes it. */
  readonly subscribe = this.changed.on;

  constructor(private current: T) {}

  get value(): Readonly<T> {
    return this.current;
  }

  /** Replaces the named fields. Listeners are called if a value has changed. */
  set(change: Partial<T>): void {
    const before = this.current;
    const keys = Object.keys(change) as (keyof T)[];
    if (keys.every((key) => Object.is(before[key], change[key]))) return;
    this.current = { ...before, ...change };
    this.changed.emit(this.current, before);
  }
}

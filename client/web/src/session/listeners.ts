// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** The listeners of several kinds of events. */
export class Listeners<Events extends { [K in keyof Events]: (...args: never[]) => void }> {
  private readonly lists = new Map<keyof Events, Set<Events[keyof Events]>>();

  /** Returns a function that removes the listener. */
  on<K extends keyof Events>(event: K, listener: Events[K]): () => void {
    const list = this.lists.get(event) ?? new Set();
    this.lists.set(event, list);
    list.add(listener);
    return () => void list.delete(listener);
  }

  emit<K extends keyof Events>(event: K, ...args: Parameters<Events[K]>): void {
    for (const listener of [...(this.lists.get(event) ?? [])]) (listener as (...args: Parameters<Events[K]>) => void)(...args);
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scenes that this browser has opened from this server, newest first.
const STORAGE_KEY = 'latticed.recent';
const MOST = 6;

export interface RecentScene {
  readonly id: string;
  readonly name: string;
}

export class RecentScenes {
  /** @param storage If it refuses, there are none. */
  constructor(private readonly storage: Pick<Storage, 'getItem' | 'setItem'>) {}

  list(): RecentScene[] {
    try {
      const kept: unknown = JSON.parse(this.storage.getItem(STORAGE_KEY) ?? '[]');
      return Array.isArray(kept) ? kept.filter(isScene) : [];
    } catch {
      return [];
    }
  }

  add(scene: RecentScene): void {
    this.write([scene, ...this.list().filter(({ id }) => id !== scene.id)].slice(0, MOST));
  }

  forget(gone: string): void {
    this.write(this.list().filter(({ id }) => id !== gone));
  }

  private write(scenes: RecentScene[]): void {
    try {
      this.storage.setItem(STORAGE_KEY, JSON.stringify(scenes));
    } catch {
      // Private windows refuse storage.
    }
  }
}

function isScene(kept: unknown): kept is RecentScene {
  const { id, name } = (kept ?? {}) as Partial<RecentScene>;
  return typeof id === 'string' && typeof name === 'string';
}

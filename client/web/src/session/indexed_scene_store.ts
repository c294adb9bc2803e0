// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { MemorySceneStore, type SceneStore, type StoredMesh, type StoredScene } from './scene_store';

/** Scenes and meshes in the browser's IndexedDB. */
export class IndexedSceneStore implements SceneStore {
  private static readonly SCENES_KEPT = 16;

  private constructor(private readonly database: IDBDatabase) {}

  /** Falls back to a store that forgets with the page. */
  static async open(name = 'latticed'): Promise<SceneStore> {
    try {
      const request = indexedDB.open(name, 1);
      request.onupgradeneeded = () => {
        request.result.createObjectStore('meshes', { keyPath: 'id' });
        request.result.createObjectStore('scenes', { keyPath: 'id' });
      };
      return new IndexedSceneStore(await done(request));
    } catch {
      return new MemorySceneStore();
    }
  }

  async mesh(id: string): Promise<StoredMesh | undefined> {
    return done<StoredMesh | undefined>(this.table('meshes', 'readonly').get(id));
  }

  async scene(id: string): Promise<StoredScene | undefined> {
    return done<StoredScene | undefined>(this.table('scenes', 'readonly').get(id));
  }

  async saveMesh(mesh: StoredMesh): Promise<void> {
    await done(this.table('meshes', 'readwrite').put(mesh));
  }

  async saveScene(scene: StoredScene): Promise<void> {
    await done(this.table('scenes', 'readwrite').put(scene));
    await this.forgetOld();
  }

  private async forgetOld(): Promise<void> {
    const scenes = await done<StoredScene[]>(this.table('scenes', 'readonly').getAll());
    if (scenes.length <= IndexedSceneStore.SCENES_KEPT) return;
    scenes.sort((a, b) => b.savedAt - a.savedAt);
    const kept = scenes.slice(0, IndexedSceneStore.SCENES_KEPT);
    for (const { id } of scenes.slice(IndexedSceneStore.SCENES_KEPT)) await done(this.table('scenes', 'readwrite').delete(id));
    const used = new Set(kept.map(({ mesh }) => mesh));
    for (const id of await done(this.table('meshes', 'readonly').getAllKeys())) {
      if (!used.has(id as string)) await done(this.table('meshes', 'readwrite').delete(id));
    }
  }

  private table(name: 'meshes' | 'scenes', mode: IDBTransactionMode): IDBObjectStore {
    return this.database.transaction(name, mode).objectStore(name);
  }
}

function done<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error('IndexedDB failed'));
  });
}

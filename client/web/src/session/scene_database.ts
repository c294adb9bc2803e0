// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// IndexedDB as promises: https://www.w3.org/TR/IndexedDB-3/.

export type SceneTable = 'scenes' | 'meshes' | 'contents' | 'companions';

/**
 * What is in the table of meshes. Contents are in one of their own: a Blob that some page has a handle to takes its room
 * even after it was deleted.
 */
export interface MeshFacts {
  readonly id: string;
  readonly header: Uint8Array;
  /** Of the content and of what was dropped beside it. */
  readonly bytes: number;
  /** Of these, what was dropped beside it. */
  readonly companionBytes: number;
  /** Date.now(). */
  readonly savedAt: number;
}

const NAME = 'latticed';
const VERSION = 3;  // of the records; those of another version are dropped

/** Opens the database, whose tables are scenes, meshes, contents and companions. Rejects where the browser gives none. */
export function openSceneDatabase(): Promise<IDBDatabase> {
  return new Promise((resolve, reject) => {
    const request = indexedDB.open(NAME, VERSION);
    request.onupgradeneeded = () => {
      const { result } = request;
      for (const name of [...result.objectStoreNames]) result.deleteObjectStore(name);
      result.createObjectStore('scenes', { keyPath: 'id' });
      result.createObjectStore('meshes', { keyPath: 'id' });
      result.createObjectStore('contents');
      result.createObjectStore('companions');
    };
    request.onblocked = () => reject(new Error('a window of another version of this page is open'));
    request.onerror = () => reject(request.error);
    request.onsuccess = () => {
      request.result.onversionchange = () => request.result.close();
      resolve(request.result);
    };
  });
}

/** The result of a request. What it has written is not safe yet: see committed(). */
export function done<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}

/** Resolves when all is written: only then does a browser say that there is no room for it. */
export function committed(transaction: IDBTransaction): Promise<void> {
  return new Promise((resolve, reject) => {
    transaction.oncomplete = () => resolve();
    transaction.onabort = () => reject(transaction.error);
  });
}

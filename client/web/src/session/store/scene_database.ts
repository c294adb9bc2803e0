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
  /** Of these, what was dropped beside it; records of version 2 lack it. */
  readonly companionBytes?: number;
  /** Date.now(). */
  readonly savedAt: number;
}

const NAME = 'latticed';
const VERSION = 3;  // of the records; version 2 has no companions, and records of version 1 are dropped

/** A newer version of the page has made the database one that this page does not know. */
export class OutdatedPage extends Error {
  constructor() {
    super('another window has a newer version of this page: reload this one');
  }
}

/**
 * Opens the database, whose tables are scenes, meshes, contents and companions; where an older window is writing, when it
 * has. Rejects where the browser gives none, or with an OutdatedPage.
 *
 * @param onClosed Told when the connection has gone: a newer window wants another version, or all was deleted.
 */
export function openSceneDatabase(onClosed: () => void): Promise<IDBDatabase> {
  return new Promise((resolve, reject) => {
    const request = indexedDB.open(NAME, VERSION);
    request.onupgradeneeded = ({ oldVersion }) => {
      const { result } = request;
      if (oldVersion < 2) makeTables(result);
      result.createObjectStore('companions');
    };
    request.onerror = () => reject(request.error?.name === 'VersionError' ? new OutdatedPage() : request.error);
    request.onsuccess = () => {
      const { result } = request;
      result.onversionchange = () => {
        result.close();
        onClosed();
      };
      result.onclose = onClosed;
      resolve(result);
    };
  });
}

/** Those of version 2. */
function makeTables(database: IDBDatabase): void {
  for (const name of [...database.objectStoreNames]) database.deleteObjectStore(name);
  database.createObjectStore('scenes', { keyPath: 'id' });
  database.createObjectStore('meshes', { keyPath: 'id' });
  database.createObjectStore('contents');
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

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// IndexedDB as promises: https://www.w3.org/TR/IndexedDB-3/.

export type SceneTable = 'scenes' | 'meshes' | 'contents' | 'companions';

/**
 * A row of the table of meshes. Contents are in a table of their own, since a Blob to which a page has a handle keeps
 * its disk space even after its row was deleted.
 */
export interface MeshFacts {
  readonly id: string;
  readonly header: Uint8Array;
  /** Size of the content. */
  readonly bytes: number;
  /** Date.now() of the save. */
  readonly savedAt: number;
}

const NAME = 'latticed';
const VERSION = 3; // of the tables; another version drops all rows

/**
 * Opens the database, whose tables are scenes, meshes, contents and companions. It waits for an older window that is
 * writing. Rejects if the browser gives no database, or if a newer page has upgraded it.
 *
 * @param onClosed Called when the connection has gone: a newer window wants another version, or everything was deleted.
 */
export async function openSceneDatabase(onClosed: () => void): Promise<IDBDatabase> {
  const request = indexedDB.open(NAME, VERSION);
  request.onupgradeneeded = () => {
    const { result } = request;
    for (const name of [...result.objectStoreNames]) result.deleteObjectStore(name);
    for (const name of ['scenes', 'meshes']) result.createObjectStore(name, { keyPath: 'id' });
    for (const name of ['contents', 'companions']) result.createObjectStore(name);
  };
  const database = await done(request);
  database.onclose = onClosed;
  database.onversionchange = () => {
    database.close();
    onClosed();
  };
  return database;
}

/** The result of a request. Its writes are not safe before committed() resolves. */
export function done<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}

/** Resolves when everything is written. A browser may report a full disk only at this point, by rejecting. */
export function committed(transaction: IDBTransaction): Promise<void> {
  return new Promise((resolve, reject) => {
    transaction.oncomplete = () => resolve();
    transaction.onabort = () => reject(transaction.error);
  });
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// IndexedDB as promises: https://www.w3.org/TR/IndexedDB-3/.

const NAME = 'latticed';
const VERSION = 4; // of the table; another version drops all rows

/** The table of the database. Its values are files. */
export const COMPANIONS = 'companions';

/**
 * Opens the database. It waits for an older window that is writing. Rejects if the browser gives no database, or if a
 * newer page has upgraded it.
 *
 * @param onClosed Called when the connection has gone: a newer window wants another version, or everything was deleted.
 */
export async function openCompanionDatabase(onClosed: () => void): Promise<IDBDatabase> {
  const request = indexedDB.open(NAME, VERSION);
  request.onupgradeneeded = () => {
    const { result } = request;
    for (const name of [...result.objectStoreNames]) result.deleteObjectStore(name);
    result.createObjectStore(COMPANIONS);
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

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** A browser opens at most six HTTP/1.1 connections to one server, for all its windows. One stays free for calls. */
export const STREAM_PLACES = 5;

/**
 * Takes one of the places that this browser's windows have for streams over HTTP, until `signal` aborts. False if all
 * are taken. Browsers give no locks to pages from other computers without TLS, and to some pages in frames. These pages
 * get true.
 */
export async function takeStreamPlace(signal: AbortSignal): Promise<boolean> {
  if (signal.aborted) return false;
  const locks = globalThis.navigator?.locks as LockManager | undefined;
  if (!locks) return true;
  const ended = new Promise<void>((resolve) => signal.addEventListener('abort', () => resolve()));
  for (let place = 0; place < STREAM_PLACES; ++place) {
    if (await takeLock(locks, `latticed-stream-${place}`, ended)) return true;
  }
  return false;
}

/** Resolves with whether the lock was free. The lock is held until `ended`. */
function takeLock(locks: LockManager, name: string, ended: Promise<void>): Promise<boolean> {
  return new Promise((resolve) => {
    const held = (lock: Lock | null): Promise<void> | undefined => {
      resolve(lock !== null);
      return lock ? ended : undefined;
    };
    locks.request(name, { ifAvailable: true }, held).catch(() => resolve(true));
  });
}

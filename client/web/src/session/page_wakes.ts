// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** What a page that comes back to life wakes. */
export interface Wakeable {
  /** What was open before the network went is of no use. */
  networkBack(): void;
  /** Somebody looks at the page again, perhaps after a sleep of the computer. */
  seen(): void;
}

/** Tells `connection` what happens to the page; returns what ends that. */
export function followPage(connection: Wakeable): () => void {
  const networkBack = (): void => connection.networkBack();
  const seen = (): void => {
    if (document.visibilityState === 'visible') connection.seen();
  };
  window.addEventListener('online', networkBack);
  document.addEventListener('visibilitychange', seen);
  return () => {
    window.removeEventListener('online', networkBack);
    document.removeEventListener('visibilitychange', seen);
  };
}

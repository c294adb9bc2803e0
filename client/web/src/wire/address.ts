// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** What the page's address asks for. The fragment is never sent to a server, so it may hold the token. */
export interface PageAddress {
  /** Scheme, host and port of the server. */
  readonly origin: string;
  readonly token?: string;
  readonly scene?: string;
}

/** Reads "http://host:port/#token=…&scene=…". */
export function readAddress(address: URL): PageAddress {
  const fragment = new URLSearchParams(address.hash.slice(1));
  const token = fragment.get('token');
  const scene = fragment.get('scene');
  return { origin: address.origin, ...(token && { token }), ...(scene && { scene }) };
}

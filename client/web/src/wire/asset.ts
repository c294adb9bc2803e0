// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Fetches a file that lies beside the page's scripts. Throws an Error whose message tells a person what is wrong. */
export async function fetchAsset(name: string): Promise<Response> {
  const response = await fetch(new URL(name, import.meta.url)).catch(() => undefined);
  // A newer server has files with other names.
  if (response?.status === 404) throw new Error('The server has been updated: reload the page');
  if (!response?.ok) throw new Error(`${name} cannot be fetched: ${response?.status ?? 'no answer'}`);
  return response;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Code } from '@connectrpc/connect';
import { ServerError } from './server_error';

/** Fetches a file that lies beside the page's scripts. Throws an error which inWords tells a person. */
export async function fetchAsset(name: string): Promise<Response> {
  const response = await fetch(new URL(name, import.meta.url)).catch(() => undefined);
  // A newer server has files with other names, so nothing is gained by another attempt.
  if (response?.status === 404) throw new ServerError(Code.FailedPrecondition, '', 'the server has been updated: reload the page');
  if (!response?.ok) throw new Error(`${name} cannot be fetched: ${response?.status ?? 'no answer'}`);
  return response;
}

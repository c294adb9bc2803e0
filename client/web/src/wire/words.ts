// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Code } from '@connectrpc/connect';
import { ServerError } from './server_error';

/**
 * An error as a sentence for people. The server's own messages say what was got, what is allowed and what to do,
 * so they are kept; words are made where it says nothing or where the viewer knows more.
 */
export function inWords(error: unknown): string {
  const failure = ServerError.fromConnect(error);
  switch (failure.reason) {
    case 'NOTHING_TO_UNDO': return 'There is nothing to undo.';
    case 'NOTHING_TO_REDO': return 'There is nothing to redo.';
    case 'UNDO_CONFLICT': return 'Somebody else has moved the same points since, so the step stays.';
    case 'STRUCTURE_CHANGED': return 'The lattice got other control points meanwhile, so the edit was dropped.';
    case 'OUT_OF_MEMORY': return outOfMemory(failure);
    case 'PERMISSION_DENIED':
      return `The token of this page does not allow that: it takes the role "${failure.metadata.role ?? 'edit'}".`;
    case 'UNAUTHENTICATED': return 'The server wants a token: open the page with #token=… at the end of its address.';
  }
  if (failure.code === Code.Unavailable && !failure.reason) return 'The server cannot be reached.';
  return sentence(failure.message || Code[failure.code] || 'unknown error');
}

/** "a b" to "A b." */
function sentence(text: string): string {
  const capital = text.charAt(0).toUpperCase() + text.slice(1);
  return /[.!?]$/.test(capital) ? capital : `${capital}.`;
}

function outOfMemory(failure: ServerError): string {
  const { asked_bytes: asked, free_bytes: free } = failure.metadata;
  // A WebSocket ends without metadata: of "needs 5000000 bytes, 1234 are free" the numbers are made readable.
  if (!asked || !free) return sentence(failure.message.replace(/\b(\d{4,})\b( bytes)?/g, (_, count: string) => bytes(Number(count))));
  return `Too large for the server: it takes ${bytes(Number(asked))} of memory, of which ${bytes(Number(free))} are free.`;
}

/** A number of bytes with a unit, three digits. */
export function bytes(count: number): string {
  const units = ['bytes', 'kB', 'MB', 'GB', 'TB'];
  let unit = 0;
  for (; count >= 1000 && unit < units.length - 1; ++unit) count /= 1000;
  return `${unit ? count.toPrecision(3) : count} ${units[unit]}`;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Code, ConnectError } from '@connectrpc/connect';
import { ServerError } from './server_error';

/**
 * An error as a sentence for people. The server's own messages tell the cause, the limit and the remedy, so they are
 * kept. Other words are used if the server gives none or the viewer knows more. Errors of the page itself are kept as
 * they are, since they may begin with a file name.
 */
export function inWords(error: unknown): string {
  const isOfServer = error instanceof ServerError || error instanceof ConnectError;
  if (error instanceof Error && !isOfServer) return ended(error.message || error.name);
  const failure = ServerError.fromConnect(error);
  switch (failure.reason) {
    case 'NOTHING_TO_UNDO': return 'There is nothing to undo.';
    case 'NOTHING_TO_REDO': return 'There is nothing to redo.';
    case 'FOLD': return 'The lattice would fold over itself around the mesh, so it stays as it is.';
    case 'UNDO_CONFLICT': return 'Somebody else has since changed or removed what this step changed, so it cannot be undone.';
    case 'STRUCTURE_CHANGED': return 'The lattice got other control points meanwhile, so the edit was dropped.';
    case 'LAST_LATTICE': return 'The last lattice of a scene stays.';
    case 'LATTICE_REMOVED': return 'The lattice was removed meanwhile, so the edit was dropped.';
    case 'OUT_OF_MEMORY': return outOfMemory(failure);
    case 'MALFORMED_FILE': return sentence(failure.message.replace(/^data: /, ''));
    case 'PERMISSION_DENIED':
      return `The token of this page does not allow that: it needs the role "${failure.metadata.role ?? 'edit'}".`;
    case 'UNAUTHENTICATED': return 'The server needs a token that is valid: open the page with #token=… at the end of its address.';
  }
  if (failure.code === Code.Unavailable && !failure.reason) return 'The server cannot be reached.';
  if (failure.code === Code.DeadlineExceeded && !failure.reason) return 'The server did not answer in time.';
  return sentence(failure.message || Code[failure.code] || 'unknown error');
}

/** Asks for a token. `hadOne`: the page has one that the server does not take. */
export function tokenWanted(hadOne: boolean): string {
  return hadOne
    ? 'The token of this page has expired, or is not valid. What you edit waits here for another one.'
    : 'The server needs a token.';
}

/** "a b" to "A b." */
function sentence(text: string): string {
  return ended(text.charAt(0).toUpperCase() + text.slice(1));
}

function ended(text: string): string {
  return /[.!?…]$/.test(text) ? text : `${text}.`;
}

/**
 * Reads "the view needs 5000000 bytes, 1234 are free", with or without "of what one caller may use": a closed WebSocket
 * or a failed download gives no metadata.
 */
function outOfMemory({ message, metadata }: ServerError): string {
  const [, what, asked, free, share] =
    /^(.+) needs (\d+) bytes, (\d+) are free( of what one caller may use)?$/.exec(message) ?? [];
  const wanted = metadata.asked_bytes ?? asked;
  const left = metadata.free_bytes ?? free;
  if (!wanted || !left) return sentence(message);
  const forWhat = what === undefined ? '' : ` for ${what}`;
  const [needed, available] = [bytes(Number(wanted)), bytes(Number(left))];
  if (share || metadata.share) {
    return `More than you may use: ${needed} of memory are needed${forWhat}, and ${available} of your share are free.`;
  }
  return `Too large for the server: ${needed} of memory are needed${forWhat}, and ${available} are free.`;
}

/** A number of bytes with a unit; three digits from kB on. */
export function bytes(count: number): string {
  const units = ['bytes', 'kB', 'MB', 'GB', 'TB'];
  let unit = 0;
  for (; count >= 1000 && unit < units.length - 1; ++unit) count /= 1000;
  return `${unit ? count.toPrecision(3) : count} ${units[unit]}`;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How long the page waits. A server or a proxy may take a call and never answer it.
import { Code, ConnectError, type Transport } from '@connectrpc/connect';

const ANSWER_MS = 15_000;
/** Of calls that send much, or for which the server computes: parts and meshes, and scenes of large meshes. */
export const LONG_CALL_MS = 300_000;

/** Gives calls with one answer a deadline, where they name none. Streams have none: see withoutSilence. */
export function withDeadlines(transport: Transport): Transport {
  return {
    unary: (method, signal, timeoutMs = ANSWER_MS, ...rest) => transport.unary(method, signal, timeoutMs, ...rest),
    stream: (...call) => transport.stream(...call),
  };
}

/** The messages of a call, which ends by `abort` with DEADLINE_EXCEEDED if the next one takes longer than `ms`. */
export async function* withoutSilence<T>(messages: AsyncIterable<T>, abort: AbortController, ms = ANSWER_MS): AsyncGenerator<T> {
  const late = (): void => abort.abort(new ConnectError('the stream fell silent', Code.DeadlineExceeded));
  let timer = setTimeout(late, ms);
  try {
    for await (const message of messages) {
      clearTimeout(timer);
      yield message;
      timer = setTimeout(late, ms);
    }
  } finally {
    clearTimeout(timer);
  }
}

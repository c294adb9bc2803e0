// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Hello, SceneEvent } from 'latticed/v1/event_pb';
import { Code } from '@connectrpc/connect';
import type { DeformRequestInit, OpenStream, SceneStream, WatchRequestInit } from '../wire/scene_stream';
import { ServerError } from '../wire/server_error';

/**
 * Pauses between attempts. They double from the first to the last, with jitter; they stay below a second for 30 s, in
 * which a server that was restarted is back.
 */
export interface BackOff {
  readonly firstMs: number;
  readonly lastMs: number;
}

type Timer = ReturnType<typeof setTimeout>;

/** After a stream has ended: open another one at once, after a pause, or not at all. */
export type AfterEnd = 'open' | 'retry' | 'stop';

export interface ConnectionHost {
  /** The request that opens the next stream. */
  request(): WatchRequestInit;
  /** A stream is open. */
  opened(hello: Hello): void;
  event(event: SceneEvent): void;
  /** A stream is lost and will be opened again. */
  retrying(error: ServerError | undefined): void;
  /** An error that does not pass by itself has ended the stream. Resolves with what to do next. */
  ended(error: ServerError): Promise<AfterEnd>;
  /** Makes another call to the server. Resolves with its error; undefined if it is answered. */
  probe(): Promise<ServerError | undefined>;
}

/** Called when the page wakes up. */
export interface Wakeable {
  /** The network is back. Streams that were open before are of no use. */
  networkBack(): void;
  /** A person looks at the page again, perhaps after the computer slept. */
  seen(): void;
}

/** Calls `connection` when the page wakes up; the function returned ends that. */
export function followPage(connection: Wakeable): () => void {
  const ended = new AbortController();
  const { signal } = ended;
  window.addEventListener('online', () => connection.networkBack(), { signal });
  document.addEventListener('visibilitychange', () => document.visibilityState === 'visible' && connection.seen(), { signal });
  return () => ended.abort();
}

/**
 * Keeps a stream of one scene open. It sends heartbeats, notices silence, obeys goaway, and opens another stream after
 * a loss. If a WebSocket fails twice while other calls pass, it uses the next kind of stream until that one is lost.
 */
export class SceneConnection implements Wakeable {
  private static readonly SILENT_HEARTBEATS = 2.5;
  private static readonly MOST_DOUBLINGS = 5;
  private static readonly BUSY_MS = 200;
  private static readonly FIRST_EVENT_MS = 15_000;
  private static readonly SOON_MS = 1000;
  private static readonly SOON_FOR_MS = 30_000;

  private stream: SceneStream | undefined;
  private kind = 0;
  private doubted = false;  // a stream did not open while other calls passed
  private heard = false;  // whether anything came on this stream
  private heardAt = 0;  // Date.now(), which goes on while the computer sleeps; timers do not
  private attempts = 0;  // since a stream last worked
  private silences = 0;  // that have ended streams within an update, since one was complete
  private isUpdating = false;  // or may be: no update has come whole on this stream
  private failedAt = 0;  // performance.now() before the first of them
  private openedAt = Infinity;
  private goawayMs = 0;
  private readonly timers: { heartbeat?: Timer; silence?: Timer; suspicion?: Timer | undefined; retry?: Timer } = {};
  private closed = false;
  private heartbeatMs = 0;  // of this stream

  /** @param kinds Kinds of streams, the preferred one first. */
  constructor(
    private readonly kinds: readonly OpenStream[],
    private readonly host: ConnectionHost,
    private readonly backOff: BackOff = { firstMs: 250, lastMs: 10_000 },
  ) {}

  open(): void {
    if (this.closed) return;
    this.drop();  // only one is open, even if another one was opened while a host was asked
    this.heard = false;
    this.isUpdating = true;
    this.heartbeatMs = 0;
    this.stream = this.kinds[this.kind]!(this.host.request(), {
      event: (event) => this.received(event),
      end: (error) => void this.lost(error),
    });
    this.listen();
  }

  send(message: DeformRequestInit): void {
    this.stream?.send(message);
  }

  /** Ends this stream and opens another, after a pause. */
  reopen(): void {
    this.drop();
    this.retry();
  }

  close(): void {
    this.closed = true;
    this.drop();
  }

  // Wakeable

  networkBack(): void {
    if (!this.stream && !this.timers.retry) return;
    if (this.stream) this.host.retrying(undefined);
    this.kind = 0;  // the limits of the old network say nothing about this one
    this.doubted = false;
    this.open();
  }

  seen(): void {
    this.listenToClock();
    if (this.timers.retry) this.open();
  }

  private received(event: SceneEvent): void {
    this.heard = true;
    this.doubted = false;
    const { case: kind, value } = event.event;
    if (kind === 'hello') this.begin(value);
    else if (kind === 'updateBegin') this.isUpdating = true;
    else if (kind === 'updateEnd') this.updated();
    else if (kind === 'goaway') this.goawayMs = milliseconds(value.retryAfter);
    this.listen();
    if (kind === 'hello') this.host.opened(value);
    this.host.event(event);
  }

  private updated(): void {
    this.attempts = this.silences = 0;
    this.isUpdating = false;
  }

  /** Doubled within an update, and again for each silence there. A message may fill a slow line, and a browser tells of it at its end. */
  private get silenceMs(): number {
    if (this.heartbeatMs === 0) return SceneConnection.FIRST_EVENT_MS;
    const doublings = this.isUpdating ? Math.min(1 + this.silences, SceneConnection.MOST_DOUBLINGS) : 0;
    return SceneConnection.SILENT_HEARTBEATS * this.heartbeatMs * 2 ** doublings;
  }

  private begin(hello: Hello): void {
    this.openedAt = performance.now();
    this.goawayMs = 0;
    this.heartbeatMs = milliseconds(hello.heartbeat);
    if (this.heartbeatMs > 0) this.timers.heartbeat = setInterval(() => this.beat(), this.heartbeatMs);
  }

  private beat(): void {
    this.send({ message: { case: 'heartbeat', value: {} } });
    if (this.isSilent) this.suspect();
  }

  /** Starts to wait for the next event. */
  private listen(): void {
    this.heardAt = Date.now();
    this.stopListening();
    this.timers.silence = setTimeout(() => this.suspect(), this.silenceMs);
  }

  /** Gives up unless something comes at once: a page that was busy has not yet seen what came meanwhile. */
  private suspect(): void {
    this.timers.suspicion ??= setTimeout(() => this.giveUp(), SceneConnection.BUSY_MS);
  }

  private stopListening(): void {
    clearTimeout(this.timers.silence);
    clearTimeout(this.timers.suspicion);
    this.timers.suspicion = undefined;
  }

  /** Ends a stream that was silent for too long by the clock, as after a sleep. */
  private listenToClock(): void {
    if (this.isSilent) this.giveUp();
  }

  private get isSilent(): boolean {
    return this.stream !== undefined && Date.now() - this.heardAt > this.silenceMs;
  }

  private giveUp(): void {
    if (this.heard && this.isUpdating) ++this.silences;
    void this.lost(this.heard ? undefined : new ServerError(Code.Unavailable, '', 'nothing came'));
  }

  private async lost(error: ServerError | undefined): Promise<void> {
    const refused = !this.heard && error?.code === Code.Unavailable && !error.reason;
    if (this.heard) this.kind = 0;
    this.drop();
    if (error && !error.isPassing) return this.endedBy(error);
    this.host.retrying(error);
    if (!refused) return this.retry(error?.code === Code.DeadlineExceeded ? this.backOff.lastMs : 0);
    // A browser does not tell why a WebSocket did not open; another call does.
    const failure = await this.host.probe();
    if (this.stream) return;  // opened meanwhile, as with another token
    if (failure && !failure.isPassing) return this.endedBy(failure);
    if (failure || this.kind + 1 === this.kinds.length) return this.retry();
    if (this.doubted) ++this.kind;
    this.doubted = !this.doubted;  // after the first failure the network may have come back before the call
    this.open();
  }

  private async endedBy(error: ServerError): Promise<void> {
    const next = await this.host.ended(error);
    if (next === 'open') this.open();
    else if (next === 'retry') this.retry();
  }

  /** @param leastMs Least pause: it spares a server that does not answer, and lets a person read why. */
  private retry(leastMs = 0): void {
    if (this.closed) return;
    this.stopRetry();
    const { firstMs, lastMs } = this.backOff;
    if (performance.now() - this.openedAt > lastMs) this.attempts = 0;
    this.openedAt = Infinity;
    if (this.attempts === 0) this.failedAt = performance.now();
    const isSoon = performance.now() - this.failedAt < SceneConnection.SOON_FOR_MS;
    const longest = isSoon ? Math.max(firstMs, Math.min(lastMs, SceneConnection.SOON_MS)) : lastMs;
    const pause = Math.min(firstMs * 2 ** this.attempts++, longest) * (0.5 + Math.random() / 2);
    this.timers.retry = setTimeout(() => this.open(), Math.max(pause, leastMs, this.goawayMs));
  }

  private drop(): void {
    this.stream?.close();
    this.stream = undefined;
    clearInterval(this.timers.heartbeat);
    this.stopListening();
    this.stopRetry();
  }

  private stopRetry(): void {
    clearTimeout(this.timers.retry);
    delete this.timers.retry;
  }
}

function milliseconds(duration: { seconds: bigint; nanos: number } | undefined): number {
  return duration ? 1000 * Number(duration.seconds) + duration.nanos / 1e6 : 0;
}

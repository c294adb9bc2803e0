// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Hello, SceneEvent } from 'latticed/v1/event_pb';
import { Code } from '@connectrpc/connect';
import type { DeformRequestInit, OpenStream, SceneStream, WatchRequestInit } from '../wire/scene_stream';
import type { ServerError } from '../wire/server_error';

/** Pauses between attempts: doubled from the first to the last, with jitter. */
export interface BackOff {
  readonly firstMs: number;
  readonly lastMs: number;
}

type Timer = ReturnType<typeof setTimeout>;

export interface ConnectionHost {
  /** What opens the next stream. */
  request(): WatchRequestInit;
  /** A stream is open. */
  opened(hello: Hello): void;
  event(event: SceneEvent): void;
  /** A stream is lost and will be opened again. */
  retrying(error: ServerError | undefined): void;
  /** Ended by an error that time does not mend; true: open again at once. */
  ended(error: ServerError): Promise<boolean>;
  /** What another call to the server fails with; undefined where it is answered. */
  probe(): Promise<ServerError | undefined>;
}

/**
 * Keeps a stream of one scene open: heartbeats both ways, silence noticed, goaway heeded, and after a loss another
 * stream. Where WebSockets do not pass but other calls do, the next kind of stream is used from then on.
 */
export class SceneConnection {
  private static readonly SILENT_HEARTBEATS = 3;
  private static readonly FIRST_EVENT_MS = 15_000;

  private stream: SceneStream | undefined;
  private kind = 0;
  private heard = false;  // anything on this stream
  private attempts = 0;  // since a stream was of use
  private openedAt = Infinity;
  private goawayMs = 0;
  private readonly timers: { heartbeat?: Timer; silence?: Timer; retry?: Timer } = {};
  private closed = false;
  private silenceMs = SceneConnection.FIRST_EVENT_MS;

  /** @param kinds Kinds of streams, the best first. */
  constructor(
    private readonly kinds: readonly OpenStream[],
    private readonly host: ConnectionHost,
    private readonly backOff: BackOff = { firstMs: 250, lastMs: 10_000 },
  ) {}

  open(): void {
    if (this.closed) return;
    clearTimeout(this.timers.retry);
    this.heard = false;
    this.silenceMs = SceneConnection.FIRST_EVENT_MS;
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

  private received(event: SceneEvent): void {
    this.heard = true;
    this.listen();
    const { case: kind, value } = event.event;
    if (kind === 'hello') this.begin(value);
    else if (kind === 'updateEnd') this.attempts = 0;
    else if (kind === 'goaway') this.goawayMs = milliseconds(value.retryAfter);
    this.host.event(event);
  }

  private begin(hello: Hello): void {
    this.openedAt = performance.now();
    this.goawayMs = 0;
    const heartbeatMs = milliseconds(hello.heartbeat);
    if (heartbeatMs > 0) {
      this.silenceMs = SceneConnection.SILENT_HEARTBEATS * heartbeatMs;
      this.timers.heartbeat = setInterval(() => this.send({ message: { case: 'heartbeat', value: {} } }), heartbeatMs);
      this.listen();
    }
    this.host.opened(hello);
  }

  /** Begins to wait for the next event. */
  private listen(): void {
    clearTimeout(this.timers.silence);
    this.timers.silence = setTimeout(() => {
      this.host.retrying(undefined);
      this.reopen();
    }, this.silenceMs);
  }

  private async lost(error: ServerError | undefined): Promise<void> {
    const refused = !this.heard && error?.code === Code.Unavailable && !error.reason;
    this.drop();
    if (error && !error.isPassing) return this.endedBy(error);
    this.host.retrying(error);
    if (!refused) return this.retry();
    // A browser does not tell why a WebSocket did not open: another call does.
    const failure = await this.host.probe();
    if (failure && !failure.isPassing) return this.endedBy(failure);
    if (failure || this.kind + 1 === this.kinds.length) return this.retry();
    ++this.kind;
    this.open();
  }

  private async endedBy(error: ServerError): Promise<void> {
    if (await this.host.ended(error)) this.open();
  }

  private retry(): void {
    if (this.closed) return;
    const { firstMs, lastMs } = this.backOff;
    if (performance.now() - this.openedAt > lastMs) this.attempts = 0;
    this.openedAt = Infinity;
    const pause = Math.min(firstMs * 2 ** this.attempts++, lastMs) * (0.5 + Math.random() / 2);
    this.timers.retry = setTimeout(() => this.open(), Math.max(pause, this.goawayMs));
  }

  private drop(): void {
    this.stream?.close();
    this.stream = undefined;
    clearInterval(this.timers.heartbeat);
    clearTimeout(this.timers.silence);
    clearTimeout(this.timers.retry);
  }
}

function milliseconds(duration: { seconds: bigint; nanos: number } | undefined): number {
  return duration ? 1000 * Number(duration.seconds) + duration.nanos / 1e6 : 0;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, type CallOptions } from '@connectrpc/connect';
import { StatusSchema } from 'google/rpc/status_pb';
import { type EditBatch, type EditResult, EditResultSchema } from 'latticed/v1/edit_pb';
import { SceneEventSchema } from 'latticed/v1/event_pb';
import { DeformRequestSchema, type ControlWatchRequest } from 'latticed/v1/scene_pb';
import type { LatticedServer } from './latticed_server';
import type { DeformRequestInit, SceneStream, StreamHandlers, WatchRequestInit } from './scene_stream';
import { ServerError } from './server_error';
import { STREAM_PLACES, takeStreamPlace } from './stream_places';

const LIMIT = `without WebSockets a browser shows ${STREAM_PLACES} of its windows at once`;

const UNTAKEN = [
  Code.Unavailable, Code.Canceled, Code.Unknown, Code.Internal, Code.DeadlineExceeded, Code.Unauthenticated];

type Controls = Partial<Pick<ControlWatchRequest, 'ackedUpdateId' | 'view' | 'pause' | 'presence'>>;

/**
 * Watch, ApplyEdits and ControlWatch over gRPC-Web, in place of Deform if a proxy lets no WebSocket pass. The events
 * are the same. A refused edit is an edit_result here too.
 */
export class WatchStream implements SceneStream {
  private static readonly CALL_MS = 15_000;

  private readonly abort = new AbortController();
  private watchId = '';
  private ended = false;
  private unsent: Controls | undefined;  // the newest of each, sent once the watch is open and no call runs
  private isControlling = false;

  constructor(
    private readonly server: LatticedServer,
    private readonly open: WatchRequestInit,
    private readonly handlers: StreamHandlers,
  ) {
    void this.watch();
  }

  send(init: DeformRequestInit): void {
    const { message } = create(DeformRequestSchema, init);
    if (message.case === 'edit') void this.edit(message.value);
    else if (message.case === 'control') this.control(message.value);
    else if (message.case === 'presence') this.control({ presence: message.value });
    else if (message.case === 'heartbeat') this.control({});
  }

  close(): void {
    this.ended = true;
    this.abort.abort();
  }

  private async watch(): Promise<void> {
    const { signal } = this.abort;
    try {
      if (!(await takeStreamPlace(signal))) throw noPlace();
      const headers = { 'latticed-scene': this.open.scene ?? '' };
      for await (const event of this.server.scenes.watch(this.open, { signal, headers })) {
        if (this.ended) return;
        if (event.event.case === 'hello') this.watchId = event.event.value.watchId;
        this.handlers.event(event);
        if (event.event.case === 'hello') void this.sendControls();
      }
      this.end(undefined);
    } catch (error) {
      this.end(ServerError.fromConnect(error));
    }
  }

  private async edit(batch: EditBatch): Promise<void> {
    const request = { ...batch, scene: this.open.scene ?? '', editorId: this.open.editorId ?? '' };
    try {
      this.answer(await this.server.scenes.applyEdits(request, this.callOptions));
    } catch (error) {
      const refusal = ConnectError.from(error);
      // A lost answer, or the end of the token, ends the stream, so that the next stream sends the same batch again.
      if (UNTAKEN.includes(refusal.code)) {
        this.end(failureOf(error));
        return;
      }
      const failure = ServerError.fromConnect(error);
      this.answer(create(EditResultSchema, {
        sequence: batch.sequence,
        status: create(StatusSchema, { code: failure.code, message: failure.message, details: detailsOf(refusal) }),
      }));
    }
  }

  private control({ ackedUpdateId, view, pause, presence }: Partial<ControlWatchRequest>): void {
    this.unsent = {
      ...this.unsent,
      ...(ackedUpdateId !== undefined && { ackedUpdateId }), ...(view && { view }), ...(pause !== undefined && { pause }),
      ...(presence && { presence }),
    };
    void this.sendControls();
  }

  /** Makes one call at a time, since two at once may arrive in either order. */
  private async sendControls(): Promise<void> {
    if (!this.watchId || this.isControlling) return;
    this.isControlling = true;
    try {
      for (let controls = this.unsent; controls && !this.ended; controls = this.unsent) {
        this.unsent = undefined;
        await this.server.scenes.controlWatch({ watchId: this.watchId, scene: this.open.scene ?? '', ...controls }, this.callOptions);
      }
    } catch (error) {
      this.end(failureOf(error));
    }
    this.isControlling = false;
  }

  private get callOptions(): CallOptions {
    return { signal: this.abort.signal, timeoutMs: WatchStream.CALL_MS };
  }

  private answer(result: EditResult): void {
    if (!this.ended) this.handlers.event(create(SceneEventSchema, { event: { case: 'editResult', value: result } }));
  }

  private end(error: ServerError | undefined): void {
    if (this.ended) return;
    this.ended = true;
    this.abort.abort();
    this.handlers.end(error);
  }
}

function noPlace(): ServerError {
  return new ServerError(Code.ResourceExhausted, 'NO_STREAM_PLACE', `no WebSocket reaches the server; ${LIMIT}: close one of them`);
}

/** The failure of a call. One that timed out may have waited for a connection that other windows hold. */
function failureOf(error: unknown): ServerError {
  const failure = ServerError.fromConnect(error);
  if (failure.code !== Code.DeadlineExceeded) return failure;
  return new ServerError(failure.code, 'NO_ANSWER', `the server did not answer in time; ${LIMIT}: if more are open, close some`);
}

/** The details of a status, as google.rpc.Status holds them. */
function detailsOf(error: ConnectError): { typeUrl: string; value: Uint8Array<ArrayBuffer> }[] {
  return error.details.flatMap((detail) =>
    'type' in detail ? [{ typeUrl: `type.googleapis.com/${detail.type}`, value: detail.value.slice() }] : []);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, toBinary, type MessageInitShape } from '@bufbuild/protobuf';
import { anyPack } from '@bufbuild/protobuf/wkt';
import { ErrorInfoSchema } from 'google/rpc/error_info_pb';
import { StatusSchema, type Status } from 'google/rpc/status_pb';
import type { EditBatch } from 'latticed/v1/edit_pb';
import { SceneEventSchema } from 'latticed/v1/event_pb';
import { DeformRequestSchema, type ControlWatchRequest, type DeformRequest } from 'latticed/v1/scene_pb';
import type { OpenStream, SceneStream, StreamHandlers, WatchRequestInit } from '@src/wire/scene_stream';
import type { ServerError } from '@src/wire/server_error';

const NEWEST = 1n << 40n; // no lattice of a test is newer

/** A stream whose server is the test. */
export class FakeStream implements SceneStream {
  readonly sent: DeformRequest[] = [];
  isClosed = false;

  constructor(readonly request: WatchRequestInit, private readonly handlers: StreamHandlers) {}

  send(message: MessageInitShape<typeof DeformRequestSchema>): void {
    const made = create(DeformRequestSchema, message);
    toBinary(DeformRequestSchema, made);  // throws if it cannot be sent
    this.sent.push(made);
  }

  close(): void {
    this.isClosed = true;
  }

  event(event: MessageInitShape<typeof SceneEventSchema>['event']): void {
    if (!this.isClosed) this.handlers.event(create(SceneEventSchema, { event }));
  }

  end(error?: ServerError): void {
    if (!this.isClosed) this.handlers.end(error);
  }

  hello(headRevision = NEWEST, heartbeatMs = 0): void {
    this.event({ case: 'hello', value: { headRevision, watchId: 'w', heartbeat: { seconds: 0n, nanos: heartbeatMs * 1e6 } } });
  }

  get edits(): EditBatch[] {
    return this.sent.flatMap(({ message }) => (message.case === 'edit' ? [message.value] : []));
  }

  get controls(): ControlWatchRequest[] {
    return this.sent.flatMap(({ message }) => (message.case === 'control' ? [message.value] : []));
  }
}

/** Opens streams and keeps them, the newest last. */
export class FakeStreams {
  readonly opened: FakeStream[] = [];
  readonly open: OpenStream = (request, handlers) => {
    const stream = new FakeStream(request, handlers);
    this.opened.push(stream);
    return stream;
  };

  get newest(): FakeStream {
    return this.opened.at(-1)!;
  }
}

/** A status as the server sends it, with ErrorInfo. */
export function refusal(code: number, reason: string, message: string, metadata: Record<string, string> = {}): Status {
  const info = create(ErrorInfoSchema, { domain: 'latticed', reason, metadata });
  return create(StatusSchema, { code, message, details: [anyPack(ErrorInfoSchema, info)] });
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { MessageInitShape } from '@bufbuild/protobuf';
import type { SceneEvent } from 'latticed/v1/event_pb';
import type { DeformRequestSchema, WatchRequestSchema } from 'latticed/v1/scene_pb';
import type { ServerError } from './server_error';

export type DeformRequestInit = MessageInitShape<typeof DeformRequestSchema>;
export type WatchRequestInit = MessageInitShape<typeof WatchRequestSchema>;

export interface StreamHandlers {
  event(event: SceneEvent): void;
  /** Called once, never after close(). Without an error, the server ended the stream with OK. */
  end(error: ServerError | undefined): void;
}

/** A stream of one scene, over any transport: events in, edits and controls out. */
export interface SceneStream {
  /** Sends edits, controls, presence and heartbeats. The stream sends its opening request itself. */
  send(message: DeformRequestInit): void;
  /** Closes the stream. No handler is called afterwards. */
  close(): void;
}

/** Opens a stream. Failures are reported by `end`. */
export type OpenStream = (open: WatchRequestInit, handlers: StreamHandlers) => SceneStream;

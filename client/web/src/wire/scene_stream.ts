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
  /** Once; never after close(). Without an error the server ended the stream OK. */
  end(error: ServerError | undefined): void;
}

/** A stream of one scene: events in, edits and controls out, whatever carries it. */
export interface SceneStream {
  /** Sends edits, controls, presence and heartbeats; the stream itself sends what opens it. */
  send(message: DeformRequestInit): void;
  /** Ends it without a word. */
  close(): void;
}

/** Opens a stream; failures come by `end`. */
export type OpenStream = (open: WatchRequestInit, handlers: StreamHandlers) => SceneStream;

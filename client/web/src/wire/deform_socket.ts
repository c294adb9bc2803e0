// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import { SceneEventSchema } from 'latticed/v1/event_pb';
import { DeformRequestSchema } from 'latticed/v1/scene_pb';
import type { DeformRequestInit, SceneStream, StreamHandlers, WatchRequestInit } from './scene_stream';
import { ServerError } from './server_error';

/**
 * SceneService.Deform over a WebSocket, one message per binary frame: browsers have no other stream in both directions.
 * The token travels as an offered subprotocol, since browsers cannot set a header.
 */
export class DeformSocket implements SceneStream {
  private static readonly CLOSE_OK = 1000;
  private readonly socket: WebSocket;
  private readonly early: Uint8Array<ArrayBuffer>[] = [];  // sent before the socket was open

  constructor(origin: string, token: string | undefined, open: WatchRequestInit, private readonly handlers: StreamHandlers) {
    const url = new URL('/ws/latticed.v1.SceneService/Deform', origin);
    url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
    url.searchParams.set('latticed-scene', open.scene ?? '');
    this.socket = new WebSocket(url, ['latticed.v1', ...(token ? [`bearer.${base64Url(token)}`] : [])]);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => this.early.forEach((frame) => this.socket.send(frame));
    this.socket.onmessage = ({ data }) => this.received(data as ArrayBuffer);
    this.socket.onclose = ({ code, reason }) => this.closed(code, reason);
    this.send({ message: { case: 'watch', value: open } });
  }

  send(message: DeformRequestInit): void {
    const frame = toBinary(DeformRequestSchema, create(DeformRequestSchema, message));
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(frame);
    else this.early.push(frame);
  }

  close(): void {
    this.forget();
    this.socket.close(DeformSocket.CLOSE_OK);
  }

  private received(data: ArrayBuffer): void {
    this.handlers.event(fromBinary(SceneEventSchema, new Uint8Array(data)));
  }

  private closed(code: number, reason: string): void {
    this.forget();
    this.handlers.end(code === DeformSocket.CLOSE_OK ? undefined : ServerError.fromClose(code, reason));
  }

  private forget(): void {
    this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
  }
}

/** Encodes a token as a subprotocol may hold it. */
function base64Url(text: string): string {
  const binary = String.fromCharCode(...new TextEncoder().encode(text));
  return btoa(binary).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
}

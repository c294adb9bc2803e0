// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { fromBinary } from '@bufbuild/protobuf';
import { SceneEventSchema, type Hello, type SceneEvent } from 'latticed/v1/event_pb';
import type { Page } from 'playwright-core';

/** A WebSocket of a page, with the events that came on it. */
export class TappedSocket {
  readonly events: SceneEvent['event'][] = [];

  constructor(readonly address: string) {}

  get hello(): Hello | undefined {
    for (const event of this.events) if (event.case === 'hello') return event.value;
    return undefined;
  }

  /** The number of chunks in all topologies that came. */
  get chunksOfTopology(): number {
    const runs = this.events.flatMap((event) => (event.case === 'topology' ? event.value.chunkRuns : []));
    return runs.reduce((sum, { chunkCount }) => sum + chunkCount, 0);
  }

  /** The number of different chunks that came. */
  get chunks(): number {
    const indices = this.events.flatMap((event) => (event.case === 'chunks' ? event.value.chunks.map(({ index }) => index) : []));
    return new Set(indices).size;
  }
}

/** WebSockets that the page opens from now on, the newest last. */
export function tapSockets(page: Page): TappedSocket[] {
  const sockets: TappedSocket[] = [];
  page.on('websocket', (socket) => {
    const tapped = new TappedSocket(socket.url());
    sockets.push(tapped);
    socket.on('framereceived', ({ payload }) => {
      if (typeof payload !== 'string') tapped.events.push(fromBinary(SceneEventSchema, payload).event);
    });
  });
  return sockets;
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Presence as PresenceMessage } from 'latticed/v1/event_pb';
import { toCamera } from '../wire/camera_message';
import type { Presence } from './scene_session';

/**
 * The other editors of the scene. Sends this window's presence when it changes; the newest one wins. It is sent at most 10
 * times a second, and at most once a second while nobody else is shown: then only those who may not edit can follow.
 */
export class Presences {
  private static readonly PAUSE_MS = 100;
  private static readonly PAUSE_ALONE_MS = 1000;
  private static readonly MOST_SELECTED = 1024;

  private readonly here = new Map<string, Presence>();
  private own: Presence | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private sentAt = -Infinity;

  /** @param send Sends this window's presence. */
  constructor(private readonly send: (own: Presence) => void) {}

  get others(): ReadonlyMap<string, Presence> {
    return this.here;
  }

  take(message: PresenceMessage): void {
    if ('left' in message && message.left) {
      this.here.delete(message.editorId);
      return;
    }
    const camera = message.camera && toCamera(message.camera);
    const { name, colour, lattice, following } = message;
    const selected = Uint32Array.from(message.selectedIndices);
    this.here.set(message.editorId, { name, colour, selected, lattice, ...(camera && { camera }), following });
  }

  /** Changes what this window shows. Nothing is sent before the first call. */
  announce(change: Partial<Presence>): void {
    this.own = { name: '', colour: 0, selected: new Uint32Array(), lattice: 0, following: '', ...this.own, ...change };
    this.sendSoon();
  }

  /** A stream is open: it sends all other editors, and needs this window's presence again. */
  opened(): void {
    this.here.clear();
    this.close(); // what waits need not wait any longer
    this.sentAt = -Infinity;
    if (this.own) this.sendSoon();
  }

  close(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
  }

  private sendSoon(): void {
    const pause = this.here.size === 0 ? Presences.PAUSE_ALONE_MS : Presences.PAUSE_MS;
    this.timer ??= setTimeout(() => this.flush(), Math.max(0, this.sentAt + pause - performance.now()));
  }

  private flush(): void {
    this.timer = undefined;
    this.sentAt = performance.now();
    const { own } = this;
    if (own) this.send({ ...own, selected: own.selected.slice(0, Presences.MOST_SELECTED) });
  }
}

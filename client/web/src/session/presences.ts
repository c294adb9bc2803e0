// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Presence as PresenceMessage } from 'latticed/v1/event_pb';
import type { Presence } from './scene_session';

/** The other editors of the scene. Sends this window's selection at most 10 times a second; the newest one wins. */
export class Presences {
  private static readonly PAUSE_MS = 100;
  private static readonly MOST_SELECTED = 1024;

  private readonly here = new Map<string, Presence>();
  private selected: Uint32Array | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private sentAt = -Infinity;

  /** @param send Sends this window's selection. */
  constructor(private readonly send: (selected: number[]) => void) {}

  get others(): ReadonlyMap<string, Presence> {
    return this.here;
  }

  take(message: PresenceMessage): void {
    if ('left' in message && message.left) {
      this.here.delete(message.editorId);
      return;
    }
    this.here.set(message.editorId, {
      name: message.name, colour: message.colour, selected: Uint32Array.from(message.selectedIndices) });
  }

  announce(selected: Uint32Array): void {
    this.selected = selected.slice(0, Presences.MOST_SELECTED);
    this.timer ??= setTimeout(() => this.flush(), Math.max(0, this.sentAt + Presences.PAUSE_MS - performance.now()));
  }

  /** A stream is open: it sends all other editors, and needs this window's selection again. */
  opened(): void {
    this.here.clear();
    if (this.selected) this.announce(this.selected);
  }

  close(): void {
    clearTimeout(this.timer);
  }

  private flush(): void {
    this.timer = undefined;
    this.sentAt = performance.now();
    if (this.selected) this.send(Array.from(this.selected));
  }
}

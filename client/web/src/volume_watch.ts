// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Follows the volume that a session's surface encloses: asks the server for it when the surface has changed, one call at a
// time. An open surface has none; the watch then ends, unless it is torn, which an edit may mend.
import { Code } from '@connectrpc/connect';
import type { LiveSession } from './session/live_session';
import { ServerError } from './wire/server_error';

const PAUSE_MS = 250;

export class VolumeWatch {
  private timer = 0;
  private isAsking = false;
  private isStale = false;
  private hasEnded = false;
  private readonly end: () => void;

  /** @param show Called with the volume in world units cubed, or with why there is none. */
  constructor(private readonly session: LiveSession, private readonly show: (volume: number | string) => void) {
    this.end = session.on('update', () => this.askSoon());
    this.askSoon();
  }

  dispose(): void {
    this.hasEnded = true;
    clearTimeout(this.timer);
    this.end();
  }

  private askSoon(): void {
    this.isStale = true;
    if (!this.isAsking && !this.hasEnded) this.timer ||= window.setTimeout(() => void this.ask(), PAUSE_MS);
  }

  private async ask(): Promise<void> {
    this.timer = 0;
    this.isAsking = true;
    this.isStale = false;
    try {
      const volume = await this.session.measureVolume();
      if (!this.hasEnded) this.show(volume);
    } catch (error) {
      const { code, reason, metadata } = ServerError.fromConnect(error);
      if (code === Code.Unimplemented) this.dispose();  // an older server
      if (reason === 'OPEN_SURFACE' && !this.hasEnded) {
        const isTorn = metadata['border_edges'] === '0';
        this.show(isTorn ? 'none: the mesh is torn at the lattice' : 'none: the mesh is open');
        if (!isTorn) this.dispose();
      }
    }
    this.isAsking = false;
    if (this.isStale) this.askSoon();
  }
}

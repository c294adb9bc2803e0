// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Follows the volume that a session's surface encloses. An open surface has none; the watch then ends, unless it is torn,
// which an edit may mend.
import { Code } from '@connectrpc/connect';
import { RepeatedCall } from './repeated_call';
import type { LiveSession } from './session/live_session';
import { ServerError } from './wire/server_error';

const PAUSE_MS = 250;

export class VolumeWatch {
  private readonly measurement = new RepeatedCall(() => this.ask(), PAUSE_MS);
  private readonly end: () => void;

  /** @param show Called with the volume in world units cubed, or with why there is none. */
  constructor(private readonly session: LiveSession, private readonly show: (volume: number | string) => void) {
    this.end = session.on('update', () => this.measurement.soon());
    this.measurement.soon();
  }

  dispose(): void {
    this.measurement.end();
    this.end();
  }

  private async ask(): Promise<void> {
    try {
      const volume = await this.session.measureVolume();
      if (!this.measurement.ended) this.show(volume);
    } catch (error) {
      const { code, reason, metadata } = ServerError.fromConnect(error);
      if (code === Code.Unimplemented) this.dispose();  // an older server
      if (reason === 'OPEN_SURFACE' && !this.measurement.ended) {
        const isTorn = metadata['border_edges'] === '0';
        this.show(isTorn ? 'none: the mesh is torn at the lattice' : 'none: the mesh is open');
        if (!isTorn) this.dispose();
      }
    }
  }
}

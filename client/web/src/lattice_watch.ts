// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Follows a session's lattice with remarks about it: several times a second while it moves, since a check takes time. It ends
// with the lattice's structure, since in another frame the mesh has another extent.
import { LatticeRemarks, type Remark } from './lattice/lattice_remarks';
import type { MeshExtent } from './lattice/mesh_extent';
import type { LiveSession } from './session/live_session';

const PAUSE_MS = 200;

export class LatticeWatch {
  private readonly remarks: LatticeRemarks;
  private timer = 0;
  private readonly ends: readonly (() => void)[];

  /** @param show Called with the remarks that hold now. */
  constructor(
    private readonly session: LiveSession,
    extent: MeshExtent | undefined,
    private readonly show: (remarks: readonly Remark[]) => void,
  ) {
    this.remarks = new LatticeRemarks(session.lattice, extent);
    this.ends = [
      session.on('points', () => this.checkSoon()),
      session.on('lattice', () => this.dispose()),
    ];
    this.check();
  }

  dispose(): void {
    clearTimeout(this.timer);
    for (const end of this.ends) end();
  }

  private checkSoon(): void {
    this.timer ||= window.setTimeout(() => this.check(), PAUSE_MS);
  }

  private check(): void {
    this.timer = 0;
    this.show(this.remarks.of(this.session.lattice.points));
  }
}

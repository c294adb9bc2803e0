// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Follows a session's lattice with remarks about it: some per second while it moves. It ends
// with the lattice's structure, since in another frame the mesh has another extent.
import { LatticeRemarks, type Remark } from './lattice/lattice_remarks';
import type { MeshExtent } from './lattice/mesh_extent';
import type { LiveSession } from './session/live_session';
import type { Folds } from './wire/fold_message';

const PAUSE_MS = 200;

export class LatticeWatch {
  private readonly remarks: LatticeRemarks;
  private timer = 0;
  private ended = false;
  private readonly ends: readonly (() => void)[];

  /**
   * @param folds The server's newest report.
   * @param show Called with the remarks that hold now.
   */
  constructor(
    private readonly session: LiveSession,
    extent: MeshExtent | undefined,
    private readonly folds: () => Folds | undefined,
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
    this.ended = true;
    clearTimeout(this.timer);
    for (const end of this.ends) end();
  }

  /** Called when the report of folds may be another one. */
  checkSoon(): void {
    if (!this.ended) this.timer ||= window.setTimeout(() => this.check(), PAUSE_MS);
  }

  private check(): void {
    this.timer = 0;
    this.show(this.remarks.of(this.session.lattice, this.folds()));
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Chooses which of a scene's lattices is shown and edited. Hidden for a scene of one.
import type { LiveSession } from '../session/live_session';
import { field, type Control } from './controls';
import { h } from './dom';

export class LatticeChoice implements Control {
  readonly element: HTMLElement;
  private readonly select = h('select', {
    'aria-label': 'Lattice', onchange: () => this.session?.chooseLattice(Number(this.select.value)),
  });
  private session: LiveSession | undefined;

  constructor() {
    this.element = field('Lattice', this.select);
    this.element.title = 'Which lattice is shown and edited. What all of them move the mesh adds up';
  }

  show(session: LiveSession): void {
    this.session = session;
    this.refresh();
  }

  refresh(): void {
    const count = this.session?.latticeCount ?? 1;
    this.element.hidden = count < 2;
    if (this.select.options.length !== count) {
      this.select.replaceChildren(...Array.from({ length: count }, (_, k) => h('option', { value: String(k) }, `${k + 1} of ${count}`)));
    }
    this.select.value = String(this.session?.latticeIndex ?? 0);
  }
}

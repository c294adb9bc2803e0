// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Chooses which of a scene's lattices is shown and edited, and removes it. Hidden for a scene of one.
import type { LiveSession } from '../session/live_session';
import { button, field, type Control } from './controls';
import { h } from './dom';

export class LatticeChoice implements Control {
  readonly element: HTMLElement;
  private readonly select = h('select', {
    'aria-label': 'Lattice', onchange: () => this.session?.chooseLattice(Number(this.select.value)),
  });
  private readonly remove = button('Remove', () => this.session?.removeLattice(), {
    title: 'Remove this lattice. Undo gives it back',
  });
  private session: LiveSession | undefined;

  constructor() {
    this.element = field('Lattice', this.select, this.remove);
    this.element.title = 'Which lattice is shown and edited. What all of them move the mesh adds up';
  }

  show(session: LiveSession): void {
    this.session = session;
    this.refresh();
  }

  refresh(): void {
    const numbers = (this.session?.latticeNumbers ?? [0]).map(String);
    this.element.hidden = numbers.length < 2;
    this.remove.disabled = !this.session?.mayEdit;
    if (Array.from(this.select.options, ({ value }) => value).join() !== numbers.join()) {
      this.select.replaceChildren(...numbers.map((value, k) => h('option', { value }, `${k + 1} of ${numbers.length}`)));
    }
    this.select.value = String(this.session?.latticeIndex ?? 0);
  }
}

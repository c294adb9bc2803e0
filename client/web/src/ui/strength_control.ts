// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A slider for the scene's strength: how much of the deformation it takes. It is the scene's, so all who edit it share it. One
// slide is one undo step.
import type { LiveSession } from '../session/live_session';
import type { Gesture } from '../session/scene_session';
import { field, type Control } from './controls';
import { h } from './dom';

export class StrengthControl implements Control {
  readonly element: HTMLElement;
  private readonly output = h('output', { style: 'white-space: nowrap' });
  private readonly input = h('input', {
    type: 'range', 'aria-label': 'Strength', min: 0, max: 1, step: 0.01,
    oninput: () => this.slide(),
    onchange: () => this.end(),
  });
  private session: LiveSession | undefined;
  private gesture: Gesture | undefined;

  constructor() {
    this.element = field('Strength', this.input, this.output);
    this.element.title = 'How much of the deformation the mesh takes';
  }

  show(session: LiveSession): void {
    this.session = session;
    this.gesture = undefined;
    this.refresh();
  }

  refresh(): void {
    const strength = this.session?.lattice.strength ?? 1;
    if (!this.gesture) this.input.value = String(strength);
    this.input.disabled = !(this.session?.mayEdit ?? false);
    this.output.textContent = `${Math.round(100 * strength)} %`;
  }

  private slide(): void {
    if (!this.session) return;
    this.gesture ??= this.session.gesture({ ended: () => (this.gesture = undefined) });
    this.gesture.update({ kind: 'strength', strength: this.input.valueAsNumber });
    this.refresh();
  }

  private end(): void {
    if (this.gesture) this.gesture.commit();
    this.gesture = undefined;
    this.refresh();
  }
}

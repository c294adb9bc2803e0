// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How far soft selection reaches: a circle around the pivot, while a transform runs and while the radius is chosen.
import { svg } from '../dom';

export class SoftCircle {
  readonly element = svg('svg', { class: 'overlay soft-circle', 'aria-hidden': 'true' });
  private readonly circle = svg('circle', {});

  constructor() {
    this.element.append(this.circle);
  }

  /** In pixels of the view; undefined hides it. */
  show(at: { x: number; y: number; radius: number } | undefined): void {
    this.circle.setAttribute('r', String(at?.radius ?? 0));
    if (at === undefined) return;
    this.circle.setAttribute('cx', String(at.x));
    this.circle.setAttribute('cy', String(at.y));
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The reach of soft selection, as a circle around the pivot while a transform runs.
import { setAttributes, svg } from '../dom';

export class SoftCircle {
  private readonly circle = svg('circle', {});
  readonly element = svg('svg', { class: 'overlay soft-circle', 'aria-hidden': 'true' }, this.circle);

  /** In pixels of the view; undefined hides it. */
  show(at: { x: number; y: number; radius: number } | undefined): void {
    setAttributes(this.circle, at === undefined ? { r: 0 } : { cx: at.x, cy: at.y, r: at.radius });
  }
}

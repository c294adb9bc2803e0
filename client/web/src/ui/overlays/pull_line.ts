// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A line to the target from a pulled surface point that stays behind.
import { setAttributes, svg } from '../dom';

type Place = readonly [x: number, y: number, ...rest: number[]];

export class PullLine {
  private readonly line = svg('line', {});
  private readonly end = svg('circle', { r: 4 });
  readonly element = svg('svg', { class: 'overlay pull-line', 'aria-hidden': 'true', style: 'display: none' }, this.line, this.end);

  /** In pixels of the view. Hidden if an end cannot be seen. */
  show(from: Place | undefined, to: Place | undefined): void {
    this.element.style.display = from && to ? '' : 'none';
    if (from === undefined || to === undefined) return;
    setAttributes(this.line, { x1: from[0], y1: from[1], x2: to[0], y2: to[1] });
    setAttributes(this.end, { cx: from[0], cy: from[1] });
  }
}

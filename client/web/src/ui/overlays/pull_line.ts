// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What is pulled and does not come along: a line from there to where it should be.
import { svg } from '../dom';

type Place = readonly [x: number, y: number, ...rest: number[]];

export class PullLine {
  private readonly line = svg('line', {});
  private readonly end = svg('circle', { r: 4 });
  readonly element = svg('svg', { class: 'overlay pull-line', 'aria-hidden': 'true' }, this.line, this.end);

  constructor() {
    this.show(undefined, undefined);
  }

  /** In pixels of the view; nothing is shown where an end is not to be seen. */
  show(from: Place | undefined, to: Place | undefined): void {
    this.element.style.display = from && to ? '' : 'none';
    if (from === undefined || to === undefined) return;
    const attributes = { x1: from[0], y1: from[1], x2: to[0], y2: to[1] };
    for (const [name, value] of Object.entries(attributes)) this.line.setAttribute(name, String(value));
    this.end.setAttribute('cx', String(from[0]));
    this.end.setAttribute('cy', String(from[1]));
  }
}

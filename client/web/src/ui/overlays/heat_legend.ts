// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The legend of the heat map's colours.
import { h } from '../dom';

export class HeatLegend {
  private readonly begin = h('span', {});
  private readonly end = h('span', {});
  readonly element = h(
    'div',
    { class: 'heat-legend', role: 'img', 'aria-label': 'Colours of the distance', hidden: true },
    this.begin,
    h('i', {}),
    this.end,
  );

  /** @param range The distance at the end of the colours, in world units. 0 means unknown and hides the legend. */
  show(what: string, range = 0): void {
    this.element.hidden = range === 0;
    this.begin.textContent = `${what}  0`;
    this.end.textContent = Number(range.toPrecision(3)).toString();
  }
}

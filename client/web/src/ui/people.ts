// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The other editors of the scene: a dot for each, in the colour of the rings around the points that they have selected.
import type { Presence } from '../session/scene_session';
import { h } from './dom';

/** Easy to tell apart on light and on dark, and not used by the page itself. */
const COLOURS = [0xd65cff, 0x2ec4b6, 0xff5c8a, 0x5c7cff, 0x9bd13c, 0xffd23f, 0x00b4ff, 0xff7a45];
const NAMES = ['Plum', 'Teal', 'Rose', 'Iris', 'Fern', 'Honey', 'Sky', 'Coral'];

/** A colour for this window, and its name. */
export function randomPerson(): { name: string; colour: number } {
  const which = Math.floor(Math.random() * COLOURS.length);
  return { name: NAMES[which], colour: COLOURS[which] };
}

export class People {
  readonly element = h('div', { class: 'people', role: 'status', 'aria-label': 'Other editors' });

  show(others: Iterable<Presence>): void {
    const dots = [...others].map(({ name, colour, selected }) => {
      const points = selected.length === 1 ? 'control point' : 'control points';
      const dot = h(
        'span',
        { class: 'person', title: `${name || 'Somebody'}: ${selected.length} ${points} selected` },
        (name || '?').slice(0, 1),
      );
      dot.style.background = `#${colour.toString(16).padStart(6, '0')}`;
      return dot;
    });
    this.element.replaceChildren(...dots);
  }
}

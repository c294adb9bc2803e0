// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Says whose camera is followed: a border of their colour around the view, their name, and a button that ends it.
import { cssColour, type Person } from '../../state/person';
import { button } from '../controls';
import { h, setText } from '../dom';

export class FollowingSign {
  private readonly words = h('span', { role: 'status' });
  readonly element: HTMLElement;

  constructor(stop: () => void) {
    const line = h('div', { class: 'following-line' }, this.words, button('Stop', stop));
    this.element = h('div', { class: 'overlay following', hidden: true }, line);
  }

  show(person: Person | undefined): void {
    this.element.hidden = person === undefined;
    setText(this.words, person === undefined ? '' : `Following ${person.name || 'somebody'}`);
    if (person !== undefined) this.element.style.setProperty('--person', cssColour(person));
  }
}

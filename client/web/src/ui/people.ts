// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The people at the scene: a dot for each, in the colour of the rings around the points that they have selected. One's own
// comes first and has a ring.
import type { Presence } from '../session/scene_session';
import { cssColour, type Person } from '../state/person';
import { h, setAttributes, setText } from './dom';

export interface PeopleEvents {
  /** One's own dot was pressed. */
  you(): void;
  /** The dot of an editor was pressed. */
  other(id: string): void;
}

export class People {
  private readonly you: HTMLButtonElement;
  private readonly others = new Map<string, HTMLButtonElement>();
  readonly element: HTMLElement;

  constructor(private readonly events: PeopleEvents) {
    this.you = dot('you', () => events.you());
    this.element = h('div', { class: 'people', role: 'group', 'aria-label': 'People' }, this.you);
  }

  /**
   * @param yourId The own editor id, which others may follow.
   * @param followed The id of the person whose camera is followed.
   */
  show(you: Person, yourId: string | undefined, others: ReadonlyMap<string, Presence>, followed: string | undefined): void {
    paint(this.you, you, `You are ${you.name}. Press for another name or colour.`);
    for (const [id, button] of this.others) if (!others.has(id)) this.remove(id, button);
    for (const [id, presence] of others) this.showOther(id, presence, presence.following === yourId, id === followed);
  }

  /** A dot stays in the page while its person is here, so that it keeps the focus and a press. */
  private showOther(id: string, presence: Presence, isFollower: boolean, isFollowed: boolean): void {
    let button = this.others.get(id);
    if (button === undefined) {
      button = dot('person', () => this.events.other(id));
      this.others.set(id, button);
      this.element.append(button);
    }
    const { name, selected, camera } = presence;
    const points = selected.length === 1 ? 'control point' : 'control points';
    const follows = isFollower ? ' Follows you.' : '';
    const press = isFollowed ? ' Press to stop following.' : camera ? ' Press to follow.' : '';
    paint(button, presence, `${name || 'Somebody'}: ${selected.length} ${points} selected.${follows}${press}`);
    button.disabled = camera === undefined;
    setAttributes(button, { 'aria-pressed': String(isFollowed) });
  }

  private remove(id: string, button: HTMLButtonElement): void {
    button.remove();
    this.others.delete(id);
  }
}

function dot(name: string, onclick: () => void): HTMLButtonElement {
  return h('button', { type: 'button', class: `dot ${name}`, onclick });
}

function paint(button: HTMLButtonElement, person: Person, title: string): void {
  setAttributes(button, { title, 'aria-label': title });
  setText(button, ([...person.name][0] ?? '?').toUpperCase());
  button.style.background = cssColour(person);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks for the name and the colour that others see of oneself.
import { clipped, cssColour, PERSON_COLOURS, personOf, type Person, type You } from '../../state/person';
import { button, field } from '../controls';
import { h, moveFocus, onEnter, showDialog } from '../dom';

export interface YouChoice {
  readonly you: You;
  /** This window's person while nothing is chosen. */
  readonly random: Person;
  /** The most code points of a name. */
  readonly longestName: number;
  chosen(you: You): void;
}

export function showYouDialog({ you, random, longestName, chosen }: YouChoice): void {
  let { colour } = you;
  const limit = (): void => void (name.value = clipped(name.value, longestName));
  const name = h('input', { class: 'text', 'aria-label': 'Name', autocomplete: 'nickname', oninput: limit });
  name.value = you.name;
  const showName = (): void => void (name.placeholder = personOf({ name: '', colour }, random).name);
  const choose = (to: You['colour']): void => {
    colour = to;
    showName();
  };
  const confirm = (): void => {
    dialog.close();
    chosen({ name: name.value.trim(), colour });
  };
  showName();
  const dialog = showDialog(
    'You',
    'you-dialog',
    h('h2', {}, 'You'),
    h('p', { class: 'note' }, 'Others at a scene see this name and colour. This browser remembers them.'),
    field('Name', name),
    field('Colour', swatches(colour, random, choose)),
    h('footer', {}, button('Cancel', () => dialog.close()), button('OK', confirm, { class: 'button primary' })),
  );
  onEnter(dialog, confirm);
  name.select();
}

/** A radio group of the random colour and the named ones; arrow keys choose too. */
function swatches(chosen: You['colour'], random: Person, choose: (colour: You['colour']) => void): HTMLElement {
  const options: [colour: You['colour'], person: Person, label: string][] = [
    ['random', random, 'Random'],
    ...PERSON_COLOURS.map((person) => [person.colour, person, person.name] as [number, Person, string]),
  ];
  const buttons = options.map(([colour, person, label]) => {
    const take = (): void => {
      choose(colour);
      mark(colour);
    };
    const swatch = h('button', { type: 'button', role: 'radio', class: 'dot', title: label, 'aria-label': label, onclick: take });
    swatch.style.background = cssColour(person);
    swatch.textContent = colour === 'random' ? '?' : '';
    return swatch;
  });
  const mark = (colour: You['colour']): void =>
    buttons.forEach((swatch, i) => {
      swatch.setAttribute('aria-checked', String(options[i][0] === colour));
      swatch.tabIndex = options[i][0] === colour ? 0 : -1;
    });
  const onkeydown = (event: KeyboardEvent): void => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    moveFocus(buttons, step)?.click();
  };
  mark(chosen);
  return h('div', { class: 'swatches', role: 'radiogroup', 'aria-label': 'Colour', onkeydown }, ...buttons);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Buttons for commands, so that everything also works by touch.
import { isGrey, tooltip, type Command, type Commands } from './commands';
import { button } from './controls';
import { h, moveFocus } from './dom';
import { icon } from './icons';

export class Toolbar {
  readonly element: HTMLElement;
  private readonly buttons: [Command, HTMLButtonElement][] = [];

  /** `groups` are ids of commands. A gap separates groups. */
  constructor(label: string, className: string, commands: Commands, groups: readonly (readonly string[])[]) {
    this.element = h('div', { class: className, role: 'toolbar', 'aria-label': label });
    for (const group of groups) {
      this.element.append(h('div', { class: 'tool-group' }, ...group.map((id) => this.button(commands.get(id)))));
    }
    this.element.addEventListener('keydown', (event) => this.moveFocus(event));
    this.refresh();
  }

  refresh(): void {
    for (const [command, button] of this.buttons) {
      button.disabled = isGrey(command);
      if (command.checked !== undefined) button.setAttribute('aria-pressed', String(command.checked()));
    }
  }

  private button(command: Command): HTMLButtonElement {
    const { id, label } = command;
    const content = command.icon === undefined ? label : icon(command.icon);
    const attributes = { class: 'icon-button', title: tooltip(command), 'aria-label': label, 'data-command': id };
    const element = button(content, () => command.run(), attributes);
    this.buttons.push([command, element]);
    return element;
  }

  /** Arrow keys move from button to button, as in every toolbar. */
  private moveFocus(event: KeyboardEvent): void {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    moveFocus(this.buttons.map(([, button]) => button).filter((button) => !button.disabled), step);
  }
}

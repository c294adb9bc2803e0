// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Menus of all commands, by group, with their keys. Commands without a button are found here.
import { isGrey, type Command, type CommandGroup, type Commands } from './commands';
import { h, moveFocus } from './dom';

export class MenuBar {
  readonly element = h('nav', { class: 'menu-bar', 'aria-label': 'Menus' });
  private open: { button: HTMLElement; list: HTMLElement } | undefined;

  constructor(private readonly commands: Commands) {
    for (const group of new Set(commands.list.map((command) => command.group))) {
      const button: HTMLButtonElement = h(
        'button',
        {
          type: 'button',
          class: 'menu-button',
          'aria-haspopup': 'menu',
          'aria-expanded': 'false',
          onclick: () => (this.open?.button === button ? this.close() : this.show(button, group)),
          onpointerenter: ({ pointerType }: PointerEvent) => this.entered(button, group, pointerType),
        },
        group,
      );
      this.element.append(button);
    }
    this.element.addEventListener('keydown', (event) => this.key(event));
    window.addEventListener('pointerdown', (event) => !this.element.contains(event.target as Node) && this.close());
  }

  private show(button: HTMLElement, group: CommandGroup): void {
    this.close();
    const items = this.commands.list.filter((command) => command.group === group).map((command) => this.item(command));
    const list = h('div', { class: 'menu', role: 'menu', 'aria-label': group }, ...items);
    list.style.left = `${button.offsetLeft}px`;
    button.setAttribute('aria-expanded', 'true');
    button.after(list);
    this.open = { button, list };
    list.querySelector<HTMLElement>('button:not(:disabled)')?.focus();
  }

  /** While a menu is open, the mouse opens another by pointing at it. A tap would open it, then close it. */
  private entered(button: HTMLElement, group: CommandGroup, pointerType: string): void {
    if (pointerType !== 'touch' && this.open !== undefined && this.open.button !== button) this.show(button, group);
  }

  private item(command: Command): HTMLElement {
    const run = (): void => {
      this.close();
      command.run();
    };
    const checked = command.checked?.();
    return h(
      'button',
      {
        type: 'button',
        role: checked === undefined ? 'menuitem' : 'menuitemcheckbox',
        'aria-checked': checked === undefined ? undefined : String(checked),
        disabled: isGrey(command),
        onclick: run,
      },
      h('span', {}, command.label),
      command.keys !== undefined && h('kbd', {}, command.keys[0]),
    );
  }

  private close(): void {
    this.open?.button.setAttribute('aria-expanded', 'false');
    this.open?.list.remove();
    this.open = undefined;
  }

  private key(event: KeyboardEvent): void {
    if (this.open === undefined) return;
    const { button, list } = this.open;
    const items = [...list.querySelectorAll<HTMLElement>('button:not(:disabled)')];
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const aside = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (event.key === 'Escape') {
      this.close();
      button.focus();
    } else if (step !== undefined) {
      moveFocus(items, step);
    } else if (aside !== undefined) {
      const buttons = [...this.element.querySelectorAll<HTMLElement>('.menu-button')];
      buttons[(buttons.indexOf(button) + aside + buttons.length) % buttons.length].click();
    } else if (event.key !== 'Enter' && event.key !== ' ' && event.key !== 'Tab') {
      return;
    } else {
      return event.stopPropagation();
    }
    event.preventDefault();
    event.stopPropagation();
  }
}

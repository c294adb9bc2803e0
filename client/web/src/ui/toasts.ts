// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Messages at the edge of the view. Errors stay until they are closed, 4 newer messages come or a scene is shown.
import { button } from './controls';
import { h } from './dom';
import { icon } from './icons';

const SHOWN_MS = 5000;

export class Toasts {
  private readonly list = h('div', { class: 'toasts', role: 'log', 'aria-live': 'polite' });

  constructor(parent: HTMLElement) {
    parent.append(this.list);
  }

  tell(text: string): void {
    this.forget(text);
    const toast = this.add(text, 'toast');
    setTimeout(() => toast.remove(), SHOWN_MS);
  }

  fail(text: string): void {
    this.forget(text);
    this.add(text, 'toast toast-error');
  }

  /** Removes all errors. */
  clearErrors(): void {
    for (const toast of [...this.list.querySelectorAll('.toast-error')]) toast.remove();
  }

  /** Removes an equal toast, so that repeated messages do not stack up. */
  private forget(text: string): void {
    for (const toast of this.list.children) if (toast.firstChild?.textContent === text) toast.remove();
  }

  private add(text: string, className: string): HTMLElement {
    const close = button(icon('close'), () => toast.remove(), { class: 'icon-button', 'aria-label': 'Close' });
    const toast = h('div', { class: className }, h('span', {}, text), close);
    this.list.append(toast);
    while (this.list.childElementCount > 4) this.list.firstElementChild?.remove();
    return toast;
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What happened, in words, at the edge of the view for a while; errors stay until they are closed, or another scene is shown.
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

  /** Takes errors away that are of no meaning any more. */
  clearErrors(): void {
    for (const toast of [...this.list.querySelectorAll('.toast-error')]) toast.remove();
  }

  /** The same again does not stack up. */
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

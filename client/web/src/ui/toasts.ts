// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Messages at the edge of the view. They leave by themselves, but not below the pointer or with the focus; Esc closes all.
// A shown scene and 4 newer messages close errors too.
import { button } from './controls';
import { h } from './dom';
import { icon } from './icons';

const TOLD_MS = 5000;
const FAILED_MS = 15_000; // an error has more words

export class Toasts {
  private readonly list = h('div', { class: 'toasts', role: 'log', 'aria-live': 'polite' });

  constructor(parent: HTMLElement) {
    parent.append(this.list);
  }

  tell(text: string): void {
    this.forget(text);
    this.add(text, 'toast', TOLD_MS);
  }

  fail(text: string): void {
    this.forget(text);
    this.add(text, 'toast toast-error', FAILED_MS);
  }

  /** Removes all messages. Returns whether there were any. */
  clear(): boolean {
    const any = this.list.childElementCount > 0;
    this.list.replaceChildren();
    return any;
  }

  /** Removes all errors. */
  clearErrors(): void {
    for (const toast of [...this.list.querySelectorAll('.toast-error')]) toast.remove();
  }

  /** Removes an equal toast, so that repeated messages do not stack up. */
  private forget(text: string): void {
    for (const toast of this.list.children) if (toast.firstChild?.textContent === text) toast.remove();
  }

  private add(text: string, className: string, shownMs: number): void {
    const close = button(icon('close'), () => toast.remove(), { class: 'icon-button', 'aria-label': 'Close' });
    const toast = h('div', { class: className }, h('span', {}, text), close);
    this.list.append(toast);
    while (this.list.childElementCount > 4) this.list.firstElementChild?.remove();
    leaveAfter(toast, shownMs);
  }
}

/** Removes a toast after a time without the pointer on it and without the focus in it. */
function leaveAfter(toast: HTMLElement, ms: number): void {
  let timer = 0;
  const wait = (): void => {
    clearTimeout(timer);
    if (!toast.matches(':hover, :focus-within')) timer = window.setTimeout(() => toast.remove(), ms);
  };
  for (const kind of ['pointerenter', 'pointerleave', 'focusin', 'focusout']) toast.addEventListener(kind, wait);
  wait();
}

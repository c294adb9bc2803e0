// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A moving bar and words in the middle of the view while the page waits for a scene.
import { h } from '../dom';

export class BusySign {
  private readonly words = h('span', {});
  readonly element = h('div', { class: 'busy', role: 'status', hidden: true }, h('progress', { 'aria-label': 'Waiting' }), this.words);
  private readonly waits: string[] = [];

  /** Shows `text` until the work is done. If several works run, the newest is named. */
  async during<T>(text: string, work: Promise<T>): Promise<T> {
    this.waits.push(text);
    this.show();
    try {
      return await work;
    } finally {
      this.waits.splice(this.waits.lastIndexOf(text), 1);
      this.show();
    }
  }

  private show(): void {
    this.element.hidden = this.waits.length === 0;
    this.words.textContent = this.waits.at(-1) ?? '';
  }
}

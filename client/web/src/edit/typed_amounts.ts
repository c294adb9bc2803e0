// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers that a person types during a transform, one for each way that it may go. Keys are digits, a point, a minus
// that toggles, and Backspace; Tab goes on to the next number.

const MOST = 3;

export class TypedAmounts {
  private readonly texts: string[] = Array(MOST).fill('');
  private at = 0;
  private apart = false;
  private components = MOST;

  /** How many numbers there are; what was typed stays with the first of them. */
  set count(components: number) {
    this.components = components;
    this.at = Math.min(this.at, components - 1);
  }

  /** Whether there is no number yet. */
  get isEmpty(): boolean {
    return this.used.every((text) => Number.isNaN(Number.parseFloat(text)));
  }

  /** As it is shown: the number that takes the keys ends in a bar. Empty where nothing was typed. */
  get text(): string {
    if (!this.apart) return this.texts[0] === '' ? '' : `${this.texts[0]}|`;
    return this.used.map((text, i) => (i === this.at ? `${text}|` : text || '·')).join('  ');
  }

  /** A number for each component, `rest` for those that have none; until Tab is pressed the first is `alone`: all there is. */
  values(rest: number): { readonly numbers: readonly number[]; readonly alone: boolean } {
    const numbers = this.used.map((text) => Number.parseFloat(text));
    return { numbers: numbers.map((number) => (Number.isNaN(number) ? rest : number)), alone: !this.apart };
  }

  /** Takes a key where it is part of a number, or Tab; says whether it did. */
  key(key: string, shift: boolean): boolean {
    if (key === 'Tab') {
      this.apart = true;
      this.at = (this.at + (shift ? this.components - 1 : 1)) % this.components;
      return true;
    }
    const typed = afterKey(this.texts[this.at], key);
    this.texts[this.at] = typed ?? this.texts[this.at];
    return typed !== undefined;
  }

  /** Puts all of a text that is part of a number in place of the number that takes the keys. */
  replace(text: string): void {
    this.texts[this.at] = '';
    for (const key of text) this.key(key, false);
  }

  private get used(): readonly string[] {
    return this.texts.slice(0, this.components);
  }
}

/** The text of a number after a key; undefined where the key is no part of a number. */
function afterKey(text: string, key: string): string | undefined {
  if (/^[0-9]$/.test(key)) return text + key;
  if ((key === '.' || key === ',') && !text.includes('.')) return `${text}.`;
  if (key === '-') return text.startsWith('-') ? text.slice(1) : `-${text}`;
  if (key === 'Backspace' && text !== '') return text.slice(0, -1);
  return undefined;
}

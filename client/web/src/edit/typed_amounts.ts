// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers that a person types during a transform, one per component. Keys are digits, a point, a minus that
// toggles, and Backspace. Tab goes to the next number.

const MOST = 3;

export class TypedAmounts {
  private readonly texts: string[] = Array(MOST).fill('');
  private at = 0;
  private apart = false;
  private components = MOST;

  /** The number of components. Typed numbers stay with the first components. */
  set count(components: number) {
    this.components = components;
    this.at = Math.min(this.at, components - 1);
  }

  /** Whether no number was typed yet. */
  get isEmpty(): boolean {
    return this.used.every((text) => Number.isNaN(Number.parseFloat(text)));
  }

  /** The numbers as they are shown; the one that takes the keys ends in a bar. Empty before the first key. */
  get text(): string {
    if (!this.apart) return this.texts[0] === '' ? '' : `${this.texts[0]}|`;
    return this.used.map((text, i) => (i === this.at ? `${text}|` : text || '·')).join('  ');
  }

  /** A number per component, `rest` where none was typed. `alone`: without Tab, only the first one counts. */
  values(rest: number): { readonly numbers: readonly number[]; readonly alone: boolean } {
    const numbers = this.used.map((text) => Number.parseFloat(text));
    return { numbers: numbers.map((number) => (Number.isNaN(number) ? rest : number)), alone: !this.apart };
  }

  /** Takes Tab, or a key that is part of a number. Returns whether the key was taken. */
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

  /** Replaces the number that takes the keys by `text`. Characters that are not part of a number are ignored. */
  replace(text: string): void {
    this.texts[this.at] = '';
    for (const key of text) this.key(key, false);
  }

  private get used(): readonly string[] {
    return this.texts.slice(0, this.components);
  }
}

/** The text of a number after a key; undefined if the key is not part of a number. */
function afterKey(text: string, key: string): string | undefined {
  if (/^[0-9]$/.test(key)) return text + key;
  if ((key === '.' || key === ',') && !text.includes('.')) return `${text}.`;
  if (key === '-') return text.startsWith('-') ? text.slice(1) : `-${text}`;
  if (key === 'Backspace' && text !== '') return text.slice(0, -1);
  return undefined;
}

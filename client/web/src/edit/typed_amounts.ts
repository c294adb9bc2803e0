// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers that a person types during a transform, one for each way that it may go: Tab goes on to the next.
import { NumericEntry } from './numeric_entry';

const MOST = 3;

export class TypedAmounts {
  private readonly entries = Array.from({ length: MOST }, () => new NumericEntry());
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
    return this.used.every((entry) => entry.value === undefined);
  }

  /** As it is shown: the number that takes the keys ends in a bar. Empty where nothing was typed. */
  get text(): string {
    if (!this.apart) return this.entries[0].text === '' ? '' : `${this.entries[0].text}|`;
    return this.used.map(({ text }, i) => (i === this.at ? `${text}|` : text || '·')).join('  ');
  }

  /** A number for each component, `rest` for those that have none; until Tab is pressed the first is `alone`: all there is. */
  values(rest: number): { readonly numbers: readonly number[]; readonly alone: boolean } {
    return { numbers: this.used.map((entry) => entry.value ?? rest), alone: !this.apart };
  }

  /** Takes a key where it is part of a number, or Tab; says whether it did. */
  key(key: string, shift: boolean): boolean {
    if (key !== 'Tab') return this.entries[this.at].key(key);
    this.apart = true;
    this.at = (this.at + (shift ? this.components - 1 : 1)) % this.components;
    return true;
  }

  /** Puts a text in place of the number that takes the keys. */
  replace(text: string): void {
    this.entries[this.at].replace(text);
  }

  private get used(): readonly NumericEntry[] {
    return this.entries.slice(0, this.components);
  }
}

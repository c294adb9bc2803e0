// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The number that a person types during a transform: digits, a point, a minus that toggles, Backspace.

export class NumericEntry {
  private digits = '';
  private negative = false;

  /** What was typed, as it is shown; empty where nothing was. */
  get text(): string {
    return (this.negative ? '-' : '') + this.digits;
  }

  /** Undefined until there is a digit. */
  get value(): number | undefined {
    const magnitude = Number.parseFloat(this.digits);
    if (Number.isNaN(magnitude)) return undefined;
    return this.negative ? -magnitude : magnitude;
  }

  /** Forgets what was typed, and takes all of a text that is part of a number. */
  replace(text: string): void {
    this.digits = '';
    this.negative = false;
    for (const key of text) this.key(key);
  }

  /** Takes a key where it is part of a number; says whether it was. */
  key(key: string): boolean {
    if (/^[0-9]$/.test(key)) this.digits += key;
    else if ((key === '.' || key === ',') && !this.digits.includes('.')) this.digits += '.';
    else if (key === '-') this.negative = !this.negative;
    else if (key === 'Backspace' && this.text !== '') this.erase();
    else return false;
    return true;
  }

  private erase(): void {
    if (this.digits === '') this.negative = false;
    this.digits = this.digits.slice(0, -1);
  }
}

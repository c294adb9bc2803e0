// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The value of what a person types in a number field: numbers, pi, + - * / ^ and brackets. With += -= *= or /= in front
// it changes the value that the field has.
//
//   sum     = product { ("+" | "-") product }
//   product = factor { ("*" | "/") factor }
//   factor  = ("+" | "-") factor | power
//   power   = atom [ "^" factor ]
//   atom    = number | "pi" | "(" sum ")"

export type Evaluated = { readonly value: number } | { /** In words. */ readonly why: string };

const NUMBER = /^(?:\d+[.,]?\d*|[.,]\d+)(?:e[+-]?\d+)?/i;
const PI = /^(?:pi\b|π)/i;

export function evaluateExpression(text: string, now: number): Evaluated {
  const [, change, rest] = /^\s*(?:([-+*/])=)?(.*)$/s.exec(text)!;
  try {
    const typed = new Reader(rest).all();
    const value = change === undefined ? typed : combined(change, now, typed);
    return Number.isFinite(value) ? { value } : { why: 'This has no finite value.' };
  } catch (error) {
    return { why: (error as Error).message };
  }
}

function combined(operator: string, a: number, b: number): number {
  switch (operator) {
    case '+': return a + b;
    case '-': return a - b;
    case '*': return a * b;
    default: return a / b;
  }
}

/** Reads one expression. Throws an Error in words. */
class Reader {
  constructor(private left: string) {}

  all(): number {
    const value = this.sum();
    if (this.skipped() !== '') throw this.unknown();
    return value;
  }

  private sum(): number {
    let value = this.product();
    for (let sign = this.taken('+-'); sign; sign = this.taken('+-')) value = combined(sign, value, this.product());
    return value;
  }

  private product(): number {
    let value = this.factor();
    for (let sign = this.taken('*/'); sign; sign = this.taken('*/')) value = combined(sign, value, this.factor());
    return value;
  }

  private factor(): number {
    const sign = this.taken('+-');
    if (sign === undefined) return this.power();
    return sign === '-' ? -this.factor() : this.factor();
  }

  private power(): number {
    const base = this.atom();
    return this.taken('^') ? base ** this.factor() : base;
  }

  private atom(): number {
    if (this.taken('(')) {
      const value = this.sum();
      if (!this.taken(')')) throw this.skipped() === '' ? new Error('A closing bracket is missing.') : this.unknown();
      return value;
    }
    const number = this.matched(NUMBER);
    if (number !== undefined) return Number(number.replace(',', '.'));
    if (this.matched(PI) !== undefined) return Math.PI;
    throw this.left === '' ? new Error('A number is missing.') : this.unknown();
  }

  /** The next sign, if it is one of `signs`. */
  private taken(signs: string): string | undefined {
    const [sign] = this.skipped();
    if (sign === undefined || !signs.includes(sign)) return undefined;
    this.left = this.left.slice(1);
    return sign;
  }

  private matched(pattern: RegExp): string | undefined {
    const found = pattern.exec(this.skipped())?.[0];
    if (found !== undefined) this.left = this.left.slice(found.length);
    return found;
  }

  private skipped(): string {
    return (this.left = this.left.trimStart());
  }

  private unknown(): Error {
    const [what] = /^(?:[\p{L}_]+|.)/u.exec(this.left)!;
    return new Error(`“${what}” is not understood here.`);
  }
}

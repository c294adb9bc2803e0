// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A field for a number, which also takes expressions. A wrong one tells why below the field and changes nothing. It is
// restored when the focus goes; a field that follows the typing keeps it, with the reason. NaN, of values that differ, is shown empty.
import type { Bound, Control } from '../controls';
import { h } from '../dom';
import { evaluateExpression, type Evaluated } from './expression';

export interface NumberOptions {
  readonly min?: number;
  readonly max?: number;
  /** The step of the arrow keys. 1 by default. */
  readonly step?: number;
  /** Whether only whole numbers are taken. */
  readonly whole?: boolean;
  /** Whether the value follows the typing, instead of Enter or the loss of the focus. */
  readonly live?: boolean;
  /** Called after each typing, whether the text is a value or not. */
  readonly typed?: () => void;
  /** Called after Enter, with the value applied, and after Esc, with the value restored. It may move the focus. */
  readonly done?: () => void;
}

export interface NumberField extends Control {
  readonly input: HTMLInputElement;
  /** Whether the text is a value that the field takes. */
  isValid(): boolean;
}

export function numberField(bound: Bound<number>, options: NumberOptions = {}): NumberField {
  const { live = false, step = 1, done } = options;
  let before = bound.get(); // the value that was shown or focused last, on which += acts
  const why = h('small', { class: 'why', role: 'alert' });
  const input = h('input', {
    type: 'text',
    role: 'spinbutton',
    autocomplete: 'off',
    inputmode: options.whole && 'numeric',
    'aria-label': bound.label,
    'aria-valuemin': options.min,
    'aria-valuemax': options.max,
    onfocus: () => focused(),
    oninput: () => typed(),
    onkeydown: (event: KeyboardEvent) => key(event),
    onchange: () => leave(), // the focus goes without Enter
  });
  const element = h('span', { class: 'number-field' }, input, why);

  const evaluated = (): Evaluated => inRange(evaluateExpression(input.value, before), options);
  const isAsShown = (): boolean => input.value === shown(bound.get());
  const tell = (text: string): void => {
    why.textContent = text;
    input.setAttribute('aria-invalid', String(text !== ''));
  };
  const refresh = (): void => {
    tell('');
    before = bound.get();
    input.value = shown(before);
    input.setAttribute('aria-valuenow', input.value);
  };
  const focused = (): void => {
    before = bound.get();
    input.select();
  };
  /** Returns whether the text is a value. Shows why not. */
  const apply = (): boolean => {
    const found = evaluated();
    const isWrong = !isAsShown() && 'why' in found;
    tell(isWrong ? found.why : '');
    if ('value' in found && !isAsShown()) bound.set(found.value);
    return !isWrong;
  };
  const typed = (): void => {
    if (live) apply();
    else tell('');
    options.typed?.();
  };
  const leave = (): void => {
    if (apply() || !live) refresh();
  };
  const key = (event: KeyboardEvent): void => {
    const by = { ArrowUp: step, ArrowDown: -step }[event.key];
    if (by !== undefined) {
      event.preventDefault();
      const found = inRange({ value: bound.get() + by }, options);
      if ('value' in found) bound.set(found.value);
      refresh();
      options.typed?.();
    } else if (event.key === 'Enter') {
      event.preventDefault(); // the browser would report a change, after which a wrong text is restored
      if (!apply()) return event.stopPropagation(); // confirms nothing
      refresh();
      done?.();
    } else if (event.key === 'Escape' && done !== undefined) {
      refresh();
      done();
    }
  };
  refresh();
  return { element, input, refresh, isValid: () => isAsShown() || 'value' in evaluated() };
}

function inRange(found: Evaluated, { min = -Infinity, max = Infinity, whole = false }: NumberOptions): Evaluated {
  if ('why' in found) return found;
  const isInside = found.value >= min && found.value <= max && (!whole || Number.isInteger(found.value));
  const kind = whole ? 'A whole number' : 'A number';
  return isInside ? found : { why: max === Infinity ? `${kind} from ${min} on.` : `${kind} from ${min} to ${max}.` };
}

function shown(value: number): string {
  if (Number.isNaN(value)) return '';
  return String(Math.abs(value) < 1e-12 ? 0 : Number(value.toPrecision(4)));
}

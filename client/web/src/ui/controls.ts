// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Controls that show a value and change it. Each returns its element and a function that shows the value again.
import { h } from './dom';

export interface Control {
  readonly element: HTMLElement;
  /** Shows the value as it is. */
  refresh(): void;
}

/** A value, and what changes it. */
export interface Bound<T> {
  readonly label: string;
  get(): T;
  set(value: T): void;
  /** Whether other settings make the value meaningless. */
  isIdle?: (() => boolean) | undefined;
}

/** Makes a control and shows its value. */
function made<E extends HTMLElement>(element: E, refresh: () => void): Control & { readonly element: E } {
  refresh();
  return { element, refresh };
}

/** A label in front of anything. */
export function field(label: string, ...content: (HTMLElement | string)[]): HTMLElement {
  return h(
    'div',
    { class: 'field' },
    h('span', { class: 'field-label' }, label),
    h('div', { class: 'field-content' }, ...content),
  );
}

export function toggle({ label, get, set }: Bound<boolean>, hint?: string): Control {
  const input = h('input', { type: 'checkbox', role: 'switch', onchange: () => set(input.checked) });
  const element = h('label', { class: 'toggle', title: hint }, input, h('span', {}, label));
  return made(element, () => (input.checked = get()));
}

/** Chooses one of a few options, side by side. */
export function segmented<T extends string>({ label, get, set }: Bound<T>, options: Record<T, string>): Control {
  const buttons = (Object.entries(options) as [T, string][]).map(([value, text]) =>
    h('button', { type: 'button', role: 'radio', 'data-value': value, onclick: () => set(value) }, text),
  );
  const group = h('div', { class: 'segmented', role: 'radiogroup', 'aria-label': label }, ...buttons);
  const refresh = (): void => {
    for (const button of buttons) button.setAttribute('aria-checked', String(button.dataset['value'] === get()));
  };
  return made(field(label, group), refresh);
}

export function choice<T extends string>({ label, get, set }: Bound<T>, options: Record<T, string>): Control {
  const select = h(
    'select',
    { 'aria-label': label, onchange: () => set(select.value as T) },
    ...Object.entries<string>(options).map(([value, text]) => h('option', { value }, text)),
  );
  return made(field(label, select), () => (select.value = get()));
}

interface Range {
  readonly min: number;
  readonly max: number;
  readonly step: number | 'any';
}

/** A slider with its number beside it. With `when` 'change' it sets the value only on release. */
export function slider(bound: Bound<number>, range: Range, when: 'input' | 'change' = 'input'): Control {
  const output = h('output', {});
  const input = h('input', {
    type: 'range',
    'aria-label': bound.label,
    ...range,
    oninput: () => {
      output.textContent = shown(input.valueAsNumber);
      if (when === 'input') bound.set(input.valueAsNumber);
    },
    onchange: () => bound.set(input.valueAsNumber),
  });
  const refresh = (): void => {
    input.value = String(bound.get());
    input.disabled = bound.isIdle?.() ?? false;
    output.textContent = shown(bound.get());
  };
  return made(field(bound.label, input, output), refresh);
}

function shown(value: number): string {
  return String(Number(value.toPrecision(3)));
}

export function button(content: Node | string, onclick: () => void, attributes: Record<string, unknown> = {}): HTMLButtonElement {
  return h('button', { type: 'button', class: 'button', onclick, ...attributes }, content);
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The keys of a running transform as buttons, for pages without a keyboard: axes, planes, numbers, fine, snap, confirm,
// cancel.
import type { Editor } from '../edit/editor';
import { button } from './controls';
import { h } from './dom';
import { evaluateExpression } from './fields/expression';
import { icon } from './icons';

export class TransformBar {
  readonly element = h('div', { class: 'transform-bar', role: 'toolbar', 'aria-label': 'Running transform' });
  private readonly axes = ['X', 'Y', 'Z'].map((name) => button(name, () => this.press(name, this.plane.isOn())));
  private readonly plane = this.held('Plane', 'Keep to the plane across the axis');
  private readonly fine = this.held('Fine', 'A tenth of the way');
  private readonly snap = this.held('Snap', 'In steps');
  private readonly amount = h('input', {
    type: 'text',
    autocomplete: 'off',
    placeholder: 'amount',
    'aria-label': 'Amount',
    oninput: () => this.typed(),
    onchange: () => this.entered(),
  });
  private readonly why = h('small', { class: 'why', role: 'alert' });
  private before = 0; // the amount entered last, on which += acts

  /** `editor` returns the editor of the open scene. */
  constructor(private readonly editor: () => Editor | undefined) {
    const cancel = button(icon('close'), () => this.press('Escape'), { 'aria-label': 'Cancel' });
    const confirm = button(icon('check'), () => this.press('Enter'), { class: 'button primary', 'aria-label': 'Confirm' });
    this.element.hidden = true;
    const { axes, plane, fine, snap, amount, why } = this;
    this.element.append(...axes, plane.element, fine.element, snap.element, h('span', { class: 'number-field' }, amount, why), cancel, confirm);
  }

  /** Shows the bar while a transform runs. For each transform it starts with all switches off. */
  show(running: boolean): void {
    const axis = this.editor()?.constraint?.axis;
    this.axes.forEach((each, i) => each.setAttribute('aria-pressed', String(i === axis)));
    if (this.element.hidden === !running) return;
    this.element.hidden = !running;
    this.amount.value = '';
    this.before = 0;
    this.tell('');
    for (const switched of [this.plane, this.fine, this.snap]) switched.turnOff();
    this.hold();
  }

  private press(key: string, shift = false): void {
    this.editor()?.keyPressed(key, shift);
  }

  /** The amount follows the typing, as in other fields for numbers. A wrong expression changes nothing, and tells why. */
  private typed(): void {
    const { value } = this.amount;
    const found = evaluateExpression(value, this.before);
    const isEmpty = value.trim() === '';
    this.tell('why' in found && !isEmpty ? found.why : '');
    if ('value' in found) this.editor()?.typeAmount(decimal(found.value));
    else if (isEmpty) this.editor()?.typeAmount('');
  }

  private entered(): void {
    const found = evaluateExpression(this.amount.value, this.before);
    if ('why' in found) return;
    this.before = found.value;
    this.amount.value = decimal(found.value);
  }

  private tell(why: string): void {
    this.why.textContent = why;
    this.amount.setAttribute('aria-invalid', String(why !== ''));
  }

  private hold(): void {
    this.editor()?.hold({ shift: this.fine.isOn(), ctrl: this.snap.isOn() });
  }

  private held(label: string, title: string): { element: HTMLElement; isOn: () => boolean; turnOff: () => void } {
    const element = button(
      label,
      () => {
        element.setAttribute('aria-pressed', String(!isOn()));
        this.hold();
      },
      { title, 'aria-pressed': 'false' },
    );
    const isOn = (): boolean => element.getAttribute('aria-pressed') === 'true';
    return { element, isOn, turnOff: () => element.setAttribute('aria-pressed', 'false') };
  }
}

/** A number as a person types it: digits alone. */
function decimal(value: number): string {
  return value.toFixed(9).replace(/\.?0+$/, '');
}

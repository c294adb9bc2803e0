// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The keys of a running transform as buttons, for pages without a keyboard: axes, planes, numbers, fine, snap, confirm,
// cancel.
import type { Editor } from '../edit/editor';
import { button } from './controls';
import { h } from './dom';
import { icon } from './icons';

export class TransformBar {
  readonly element = h('div', { class: 'transform-bar', role: 'toolbar', 'aria-label': 'Running transform' });
  private readonly axes = ['X', 'Y', 'Z'].map((name) => button(name, () => this.press(name, this.plane.isOn())));
  private readonly plane = this.held('Plane', 'Keep to the plane across the axis');
  private readonly fine = this.held('Fine', 'A tenth of the way');
  private readonly snap = this.held('Snap', 'In steps');
  private readonly amount = h('input', {
    type: 'text',
    inputmode: 'decimal',
    placeholder: 'amount',
    'aria-label': 'Amount',
    oninput: () => this.editor()?.typeAmount(this.amount.value),
  });

  /** `editor` returns the editor of the open scene. */
  constructor(private readonly editor: () => Editor | undefined) {
    const cancel = button(icon('close'), () => this.press('Escape'), { 'aria-label': 'Cancel' });
    const confirm = button(icon('check'), () => this.press('Enter'), { class: 'button primary', 'aria-label': 'Confirm' });
    this.element.hidden = true;
    const { axes, plane, fine, snap, amount } = this;
    this.element.append(...axes, plane.element, fine.element, snap.element, amount, cancel, confirm);
  }

  /** Shows the bar while a transform runs. For each transform it starts with all switches off. */
  show(running: boolean): void {
    const axis = this.editor()?.constraint?.axis;
    this.axes.forEach((each, i) => each.setAttribute('aria-pressed', String(i === axis)));
    if (this.element.hidden === !running) return;
    this.element.hidden = !running;
    this.amount.value = '';
    for (const switched of [this.plane, this.fine, this.snap]) switched.turnOff();
    this.hold();
  }

  private press(key: string, shift = false): void {
    this.editor()?.keyPressed(key, shift);
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

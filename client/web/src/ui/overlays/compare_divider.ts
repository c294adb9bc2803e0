// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The divider of a split view: left of it the shape if only vertices moved, right of it the exact surface. It is dragged, or
// moved by the arrow keys. A line at the top says how far apart the two are.
import { h } from '../dom';

const KEY_STEP = 0.02; // of the view's width

const within = (at: number): number => Math.min(Math.max(at, 0), 1);

export class CompareDivider {
  private readonly apart = h('output', { class: 'compare-apart' });
  private readonly line = h('div', {
    class: 'compare-line', role: 'slider', tabindex: 0, 'aria-label': 'Divider between vertices only and exact',
    'aria-valuemin': 0, 'aria-valuemax': 100,
    onpointerdown: (event: PointerEvent) => this.press(event),
    onpointermove: (event: PointerEvent) => this.drag(event),
    onkeydown: (event: KeyboardEvent) => this.key(event),
  });
  private readonly names = h('div', { class: 'compare-names' }, h('span', {}, 'vertices only'), h('span', {}, 'exact'));
  readonly element = h('div', { class: 'overlay compare', hidden: true }, this.line, this.names, this.apart);
  private at = 0.5;

  /** @param moved Gets the divider's new place, 0 to 1 of the view's width. */
  constructor(private readonly moved: (at: number) => void) {}

  show(compare: 'off' | 'split' | 'over', at: number): void {
    this.at = at;
    this.element.hidden = compare === 'off';
    this.line.hidden = this.names.hidden = compare !== 'split';
    this.element.style.setProperty('--at', `${100 * at}%`);
    this.line.setAttribute('aria-valuenow', String(Math.round(100 * at)));
  }

  /** The largest distance between the two, and the size of the surface. World units; 0: not known. */
  tell(distance: number, size: number): void {
    const share = size > 0 ? ` (${((100 * distance) / size).toPrecision(2)} % of the size)` : '';
    this.apart.textContent = distance > 0 ? `up to ${Number(distance.toPrecision(3))} apart${share}` : '';
  }

  private press(event: PointerEvent): void {
    event.preventDefault();
    this.line.focus();
    this.line.setPointerCapture(event.pointerId);
  }

  private drag(event: PointerEvent): void {
    if (!this.line.hasPointerCapture(event.pointerId)) return;
    const box = this.element.getBoundingClientRect();
    this.moved(within((event.clientX - box.left) / box.width));
  }

  private key(event: KeyboardEvent): void {
    const step = { ArrowLeft: -KEY_STEP, ArrowRight: KEY_STEP, Home: -1, End: 1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.moved(within(this.at + step));
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What becomes of points outside a lattice: they stay, the move fades out over a width on each side, or it goes on along straight
// lines.
import { AXIS_NAMES } from '../../lattice/grid';
import type { Outside } from '../../lattice/lattice';
import { allowedWidth, MOST_WIDTH } from '../../lattice/outside';
import { button, field, segmented, toggle } from '../controls';
import { h } from '../dom';
import { numberField, type NumberField } from './number_field';

export type OutsideChoice = 'fixed' | Outside['mode'];

const WIDTHS = { min: 0, max: MOST_WIDTH, step: 0.1 };

export interface OutsideFormOptions {
  /** What is chosen at first; undefined: points stay. */
  readonly first: Outside | undefined;
  /** The width of each side where `first` has none, in lengths of the frame's edges. */
  readonly width: number;
  /** Whether a linear one has widths, too: no mesh says how far it goes. */
  readonly linearHasWidths?: boolean;
  /** What is told about each choice. */
  readonly notes: Record<OutsideChoice, string>;
  /** Called after each change, also one by setWidth. */
  changed?(): void;
}

export class OutsideForm {
  readonly element: HTMLElement;
  private chosen: OutsideChoice;
  private isSmooth: boolean;
  private sides: readonly number[];
  private readonly modes = segmented<OutsideChoice>(
    { label: 'Outside', get: () => this.chosen, set: (mode) => { this.chosen = mode; this.change(); } },
    { fixed: 'Stays', falloff: 'Falloff', linear: 'Linear' });
  private readonly smooth = toggle(
    { label: 'Smooth at the faces', get: () => this.isSmooth, set: (on) => { this.isSmooth = on; this.change(); } },
    'Without it there is a crease at the faces, and no point outside moves further than they do');
  private readonly fields: readonly NumberField[];
  private readonly ofWidths: HTMLElement;
  private readonly note = h('p', { class: 'note' });

  constructor(private readonly options: OutsideFormOptions) {
    const { first, width } = options;
    this.chosen = first?.mode ?? 'fixed';
    this.isSmooth = first?.smooth ?? true;
    this.sides = first !== undefined && this.hasWidths ? first.widths : new Array<number>(6).fill(width);
    const all = numberField(
      { label: 'Width of all sides', get: () => Math.max(...this.sides), set: (typed) => this.setWidths(this.sides.map(() => typed)) }, WIDTHS);
    const sides = [0, 1, 2, 3, 4, 5].map((side) => this.sideField(side));
    this.fields = [all, ...sides];
    const table = tableOf(sides);
    const more = button('Each side', () => more.setAttribute('aria-expanded', String(!(table.hidden = !table.hidden))), { 'aria-expanded': 'false' });
    this.ofWidths = h('div', {}, field('Width', all.element, more), table);
    this.element = h('div', { class: 'outside-form' }, this.modes.element, this.ofWidths, this.smooth.element, this.note);
    this.show();
  }

  get mode(): OutsideChoice {
    return this.chosen;
  }

  /** Of the begin and end of u, of v, of w, in lengths of the frame's edges. */
  get widths(): readonly number[] {
    return this.sides;
  }

  /** What is chosen; undefined: points stay, as without any width. */
  get wanted(): Outside | undefined {
    const { chosen: mode, sides } = this;
    if (mode === 'linear' && !this.hasWidths) return { mode, smooth: true, widths: [], steps: [] };
    if (mode === 'fixed' || sides.every((width) => width === 0)) return undefined;
    return { mode, smooth: mode === 'linear' || this.isSmooth, widths: sides, steps: [] };
  }

  /** Sides as in `widths`. */
  setWidth(side: number, width: number): void {
    this.setWidths(this.sides.map((each, other) => (other === side ? width : each)));
  }

  private setWidths(widths: readonly number[]): void {
    this.sides = widths.map(allowedWidth);
    this.change();
  }

  private get hasWidths(): boolean {
    return this.chosen === 'falloff' || (this.chosen === 'linear' && this.options.linearHasWidths === true);
  }

  private sideField(side: number): NumberField {
    const label = `Width at the ${side % 2 === 0 ? 'begin' : 'end'} of ${AXIS_NAMES[side >> 1]}`;
    return numberField({ label, get: () => this.sides[side]!, set: (typed) => this.setWidth(side, typed) }, WIDTHS);
  }

  private change(): void {
    this.show();
    this.options.changed?.();
  }

  private show(): void {
    for (const control of [this.modes, this.smooth, ...this.fields]) control.refresh();
    this.ofWidths.hidden = !this.hasWidths;
    this.smooth.element.hidden = this.chosen !== 'falloff';
    this.note.textContent = this.options.notes[this.chosen];
  }
}

/** A row for each axis, hidden at first. */
function tableOf(sides: readonly NumberField[]): HTMLElement {
  const rows = AXIS_NAMES.flatMap((name, axis) =>
    [h('b', { class: `axis-${name}` }, name), ...sides.slice(2 * axis, 2 * axis + 2).map(({ element }) => element)]);
  const group = { class: 'axes sides', role: 'group', 'aria-label': 'Width of each side' };
  return h('div', { ...group, hidden: true }, h('span', {}), h('span', {}, 'Begin'), h('span', {}, 'End'), ...rows);
}

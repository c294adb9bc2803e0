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
import { numberField, type NumberField, type NumberOptions } from './number_field';

export type OutsideChoice = 'fixed' | Outside['mode'];

export interface OutsideFormOptions {
  /** What is chosen at first; undefined: points stay. */
  readonly first: Outside | undefined;
  /** The width of each side where `first` has none, in lengths of the frame's edges. */
  readonly width: number;
  /** Whether a linear one has widths, even if `first` has none: no mesh says how far it goes. */
  readonly linearHasWidths?: boolean;
  /** What is told about each choice. */
  readonly notes: Record<OutsideChoice, string>;
  /** Called after each change, also one by setWidth, and after each typing. */
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
  private readonly all: NumberField;
  private readonly each: readonly NumberField[];
  private readonly ofWidths: HTMLElement;
  private readonly note = h('p', { class: 'note' });

  constructor(private readonly options: OutsideFormOptions) {
    const { first, width } = options;
    this.chosen = first?.mode ?? 'fixed';
    this.isSmooth = first?.smooth ?? true;
    this.sides = first !== undefined && this.hasWidths ? first.widths : new Array<number>(6).fill(width);
    this.each = [0, 1, 2, 3, 4, 5].map((side) => this.sideField(side));
    this.all = this.allField();
    const table = tableOf(this.each);
    const open = (): void => {
      table.hidden = !table.hidden;
      more.setAttribute('aria-expanded', String(!table.hidden));
      for (const one of this.each) one.refresh(); // no wrong text is left where nobody sees it
      options.changed?.();
    };
    const more = button('Each side', open, { 'aria-expanded': 'false' });
    this.ofWidths = h('div', {}, field('Width', this.all.element, more), table);
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
    const { first } = this.options;
    const isAsFirst = first?.mode === mode && sides.every((width, side) => width === first.widths[side]);
    return { mode, smooth: mode === 'linear' || this.isSmooth, widths: sides, steps: isAsFirst ? first.steps : [] };
  }

  /** Sides as in `widths`. */
  setWidth(side: number, width: number): void {
    this.takeWidth(side, width);
    this.each[side]!.refresh();
    this.options.changed?.();
  }

  /** Whether what is chosen has widths. Those that a linear one had at first stay its own. */
  get hasWidths(): boolean {
    const { chosen, options: { first, linearHasWidths = false } } = this;
    return chosen === 'falloff' || (chosen === 'linear' && (linearHasWidths || (first?.mode === 'linear' && first.widths.length > 0)));
  }

  /** Whether all texts that are shown are widths. */
  get isValid(): boolean {
    return !this.hasWidths || [this.all, ...this.each].every((one) => one.isValid());
  }

  private allField(): NumberField {
    const set = (typed: number): void => {
      this.sides = this.sides.map(() => allowedWidth(typed));
      for (const one of this.each) one.refresh();
    };
    const get = (): number => (this.sides.every((width) => width === this.sides[0]) ? this.sides[0]! : NaN);
    return numberField({ label: 'Width of all sides', get, set }, this.widthOptions);
  }

  private sideField(side: number): NumberField {
    const label = `Width at the ${side % 2 === 0 ? 'begin' : 'end'} of ${AXIS_NAMES[side >> 1]}`;
    return numberField({ label, get: () => this.sides[side]!, set: (typed) => this.takeWidth(side, typed) }, this.widthOptions);
  }

  private get widthOptions(): NumberOptions {
    return { min: 0, max: MOST_WIDTH, step: 0.1, live: true, typed: () => this.options.changed?.() };
  }

  private takeWidth(side: number, width: number): void {
    this.sides = this.sides.map((each, other) => (other === side ? allowedWidth(width) : each));
    this.all.refresh();
  }

  private change(): void {
    this.show();
    this.options.changed?.();
  }

  /** No field is refreshed: a text that is being typed stays. */
  private show(): void {
    for (const control of [this.modes, this.smooth]) control.refresh();
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

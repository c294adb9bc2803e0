// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers of control points and the degrees of a lattice, a row for each axis.
import { AXES, AXIS_NAMES, pointCount, refusalOfAxes, type Axes, type Axis } from '../../lattice/grid';
import { choice } from '../controls';
import { h } from '../dom';
import { numberField, type NumberField } from './number_field';

const DEGREES = { 1: '1, straight', 2: '2, smooth', 3: '3, smoother' };

/** Size and degree, which the table changes. */
export interface SizeAndDegree {
  size: Axes;
  degree: Axes;
}

export interface AxesTable {
  readonly element: HTMLElement;
  /** How many control points there are, or why there can be no such lattice. */
  readonly note: HTMLElement;
}

/** @param changed Called at the beginning and after each change of `values`, with whether there can be such a lattice. */
export function axesTable(values: SizeAndDegree, changed: (isValid: boolean) => void): AxesTable {
  const note = h('p', { class: 'note', role: 'status' });
  const sizes: NumberField[] = [];
  const show = (): void => {
    const refusal = refusalOfAxes(values.size, values.degree);
    note.textContent = refusal ?? `${pointCount(values.size).toLocaleString('en')} control points`;
    note.classList.toggle('error', refusal !== undefined);
    changed(refusal === undefined && sizes.every((field) => field.isValid()));
  };
  const change = (key: 'size' | 'degree', axis: Axis, value: number): void => {
    values[key] = values[key].map((n, i) => (i === axis ? value : n)) as unknown as Axes;
    show();
  };
  const rows = AXES.flatMap((axis) => {
    const name = AXIS_NAMES[axis];
    const setSize = (n: number): void => change('size', axis, n);
    const bound = { label: `Points along ${name}`, get: () => values.size[axis], set: setSize };
    const size = numberField(bound, { min: 2, max: 64, whole: true, live: true, typed: show });
    sizes.push(size);
    const setDegree = (n: string): void => change('degree', axis, Number(n));
    const degree = choice<string>({ label: `Degree along ${name}`, get: () => String(values.degree[axis]), set: setDegree }, DEGREES);
    return [h('b', { class: `axis-${name}` }, name), size.element, degree.element.querySelector('select')!];
  });
  const group = { class: 'axes', role: 'group', 'aria-label': 'Lattice' };
  const element = h('div', group, h('span', {}), h('span', {}, 'Points'), h('span', {}, 'Degree'), ...rows);
  show();
  return { element, note };
}

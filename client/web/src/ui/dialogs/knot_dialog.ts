// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks where to insert one more plane of control points: a knot strictly inside the domain of an axis.
import type { Editor } from '../../edit/editor';
import { AXIS_NAMES, domain, type Axis } from '../../lattice/grid';
import { button, field, segmented } from '../controls';
import { h, onEnter, showDialog } from '../dom';
import { numberField } from '../fields/number_field';

export function showKnotDialog(editor: Editor): void {
  let axis: Axis = 0;
  let value = editor.knotBetween(axis);
  const range = h('small', { class: 'note' });
  const knot = numberField({ label: 'Knot', get: () => value, set: (typed) => (value = typed) }, { step: 0.1, live: true });
  const show = (): void => {
    const [begin, end] = domain(editor.lattice, axis);
    range.textContent = `between ${begin} and ${end}; the shape stays as it is`;
    axes.refresh();
    knot.refresh();
  };
  const axes = segmented(
    {
      label: 'Axis',
      get: () => AXIS_NAMES[axis],
      set: (name) => {
        axis = AXIS_NAMES.indexOf(name) as Axis;
        value = editor.knotBetween(axis);
        show();
      },
    },
    { u: 'u', v: 'v', w: 'w' },
  );
  const insert = (): void => {
    dialog.close();
    editor.session.insertKnot(axis, value);
  };
  const dialog = showDialog(
    'Insert a knot plane',
    'knot',
    h('h2', {}, 'Insert a knot plane'),
    axes.element,
    field('Knot', knot.element),
    range,
    h('footer', {}, button('Cancel', () => dialog.close()), button('Insert', insert, { class: 'button primary' })),
  );
  onEnter(dialog, insert);
  show();
}

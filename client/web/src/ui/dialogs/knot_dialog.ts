// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks where to insert one more plane of control points: a knot strictly inside the domain of an axis. The view beside
// the dialog shows the plane, which follows the pointer.
import type { Editor } from '../../edit/editor';
import { AXIS_NAMES, domain, type Axis } from '../../lattice/grid';
import type { KnotPlacer } from '../../viewport/knot_placer';
import { button, field, segmented } from '../controls';
import { h, onEnter, showBeside } from '../dom';
import { numberField } from '../fields/number_field';

/** Returns a function that closes the dialog. */
export function showKnotDialog(editor: Editor, placer: KnotPlacer): () => void {
  let axis: Axis = 0;
  let value = editor.knotBetween(axis);
  const range = h('small', { class: 'note' });
  const take = (typed: number): void => {
    value = typed;
    placer.show(axis, value);
  };
  const knot = numberField({ label: 'Knot', get: () => value, set: take }, { step: 0.1, live: true });
  const show = (): void => {
    const [begin, end] = domain(editor.lattice, axis);
    range.textContent = `between ${begin} and ${end}; the shape stays as it is`;
    axes.refresh();
    knot.refresh();
    placer.show(axis, value);
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
  const dialog = showBeside(
    'Insert a knot plane',
    'knot',
    h('h2', {}, 'Insert a knot plane'),
    axes.element,
    field('Knot', knot.element),
    range,
    h('p', { class: 'note' }, 'Point at the lattice to place it, and click to insert it.'),
    h('footer', {}, button('Cancel', () => dialog.close()), button('Insert', insert, { class: 'button primary' })),
  );
  placer.onHover = (hovered) => {
    take(hovered);
    knot.refresh();
  };
  placer.onChosen = insert;
  const endLattice = editor.session.on('lattice', () => dialog.close()); // its axes have other knots
  dialog.addEventListener('close', () => {
    endLattice();
    placer.dispose();
  });
  onEnter(dialog, insert);
  show();
  knot.input.focus();
  return () => dialog.close();
}

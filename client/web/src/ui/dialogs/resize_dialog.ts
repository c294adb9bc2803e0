// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks for other numbers of control points or other degrees of the scene's lattice. The shape stays as it is, as well as
// the new lattice can.
import { AXES } from '../../lattice/grid';
import { resized } from '../../lattice/identity';
import type { LiveSession } from '../../session/live_session';
import { button } from '../controls';
import { h, onEnter, showDialog } from '../dom';
import { axesTable } from '../fields/axes_table';

/** Returns a function that closes the dialog. */
export function showResizeDialog(session: LiveSession): () => void {
  const { size, degree } = session.lattice;
  const values = { size, degree };
  const confirm = button('Change', () => change(), { class: 'button primary' });
  const table = axesTable(values, (isValid) => (confirm.disabled = !isValid));
  const change = (): void => {
    if (confirm.disabled) return;
    dialog.close();
    const isOther = AXES.some((axis) => values.size[axis] !== size[axis] || values.degree[axis] !== degree[axis]);
    if (isOther) session.replaceLattice(resized(session.lattice, values.size, values.degree), true);
  };
  const dialog = showDialog(
    'Change the lattice',
    'resize',
    h('h2', {}, 'Size and degree'),
    table.element,
    table.note,
    h('p', { class: 'note' }, 'The shape stays as it is, as well as the new lattice can.'),
    h('footer', {}, button('Cancel', () => dialog.close()), confirm),
  );
  const endLattice = session.on('lattice', () => dialog.close()); // it has another size or other knots
  dialog.addEventListener('close', endLattice);
  onEnter(dialog, change);
  return () => dialog.close();
}

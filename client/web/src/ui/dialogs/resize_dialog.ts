// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks for other numbers of control points or other degrees of the scene's lattice. The shape stays as it is, as well as
// the new lattice can.
import { restLattice } from '../../lattice/identity';
import type { LiveSession } from '../../session/live_session';
import { button } from '../controls';
import { h, onEnter, showDialog } from '../dom';
import { axesTable } from '../fields/axes_table';

export function showResizeDialog(session: LiveSession): void {
  const { frame, size, degree } = session.lattice;
  const values = { size, degree };
  const confirm = button('Change', () => change(), { class: 'button primary' });
  const table = axesTable(values, (isValid) => (confirm.disabled = !isValid));
  const change = (): void => {
    if (confirm.disabled) return;
    dialog.close();
    session.replaceLattice(restLattice(frame, values.size, values.degree), true);
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
  onEnter(dialog, change);
}

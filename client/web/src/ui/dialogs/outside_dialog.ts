// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks what goes on outside the lattice. The view beside the dialog shows the box at which it ends, with a handle on each
// face. The control points stay as they are.
import { Lattice } from '../../lattice/lattice';
import type { LiveSession } from '../../session/live_session';
import type { OutsideHandles } from '../../viewport/outside_handles';
import { button } from '../controls';
import { h, onEnter, showBeside } from '../dom';
import { OutsideForm, type OutsideChoice } from '../fields/outside_form';

const NOTES: Record<OutsideChoice, string> = {
  fixed: 'The mesh tears at a face of the lattice if its control points move.',
  falloff: 'The move fades out. Drag the handles in the view to change the width of a side.',
  linear: 'The deformation goes on along straight lines, as far as the mesh reaches.',
};
const OF_WIDTHS = 'The deformation goes on along straight lines, up to the width of each side.';

/** Returns a function that closes the dialog. */
export function showOutsideDialog(session: LiveSession, handles: OutsideHandles): () => void {
  const { outside: first } = session.lattice;
  const show = (): void => {
    confirm.disabled = !form.isValid;
    handles.show(form.widths, form.hasWidths);
  };
  const notes = first?.mode === 'linear' && first.widths.length > 0 ? { ...NOTES, linear: OF_WIDTHS } : NOTES;
  const form = new OutsideForm({ first, width: 0.3, notes, changed: show });
  const confirm = button('Change', () => change(), { class: 'button primary' });
  const change = (): void => {
    if (confirm.disabled) return;
    dialog.close();
    const { frame, degree, size, knots, points } = session.lattice;
    session.replaceLattice(new Lattice(frame, degree, size, knots, points.slice(), form.wanted), false);
  };
  const dialog = showBeside(
    'Outside the lattice', 'outside',
    h('h2', {}, 'Outside the lattice'),
    form.element,
    h('footer', {}, button('Cancel', () => dialog.close()), confirm));
  handles.onDragged = (side, dragged) => form.setWidth(side, dragged);
  const endLattice = session.on('lattice', () => dialog.close()); // it is another one
  dialog.addEventListener('close', () => {
    endLattice();
    handles.dispose();
  });
  onEnter(dialog, change);
  show();
  return () => dialog.close();
}

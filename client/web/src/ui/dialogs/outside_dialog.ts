// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks what goes on outside the lattice. The view beside the dialog shows the box at which a falloff ends, with a handle on each
// face. The control points stay as they are.
import { Lattice, type Outside } from '../../lattice/lattice';
import type { LiveSession } from '../../session/live_session';
import { allowedWidth, type OutsideHandles } from '../../viewport/outside_handles';
import { button, field, segmented, toggle } from '../controls';
import { h, onEnter, showBeside } from '../dom';
import { numberField } from '../fields/number_field';

type Mode = 'fixed' | Outside['mode'];

const FIRST_WIDTH = 0.3;
const NOTES: Record<Mode, string> = {
  fixed: 'The mesh tears at a face of the lattice if its control points move.',
  falloff: 'The move fades out. Drag the handles in the view to change the width of a side.',
  linear: 'The deformation goes on along straight lines, as far as the mesh reaches.',
};

/** Returns a function that closes the dialog. */
export function showOutsideDialog(session: LiveSession, handles: OutsideHandles): () => void {
  const { outside } = session.lattice;
  let mode: Mode = outside?.mode ?? 'fixed';
  let isSmooth = outside?.smooth ?? true;
  let widths: readonly number[] = outside?.mode === 'falloff' ? outside.widths : new Array<number>(6).fill(FIRST_WIDTH);
  const note = h('p', { class: 'note' });
  const show = (): void => {
    note.textContent = NOTES[mode];
    modes.refresh();
    smooth.refresh();
    width.refresh();
    falloff.hidden = mode !== 'falloff';
    handles.show(widths, mode === 'falloff');
  };
  const modes = segmented<Mode>(
    { label: 'Outside', get: () => mode, set: (chosen) => { mode = chosen; show(); } },
    { fixed: 'Stays', falloff: 'Falloff', linear: 'Linear' });
  const smooth = toggle({ label: 'Smooth at the faces', get: () => isSmooth, set: (on) => (isSmooth = on) },
    'Without it there is a crease at the faces, and no point outside moves further than they do');
  const width = numberField(
    { label: 'Width of all sides', get: () => Math.max(...widths), set: (typed) => { widths = widths.map(() => allowedWidth(typed)); show(); } },
    { min: 0, max: 1000, step: 0.1 });
  const falloff = h('div', {}, field('Width', width.element), smooth.element);
  const change = (): void => {
    dialog.close();
    const { frame, degree, size, knots, points } = session.lattice;
    session.replaceLattice(new Lattice(frame, degree, size, knots, points.slice(), wanted()), false);
  };
  const wanted = (): Outside | undefined => {
    if (mode === 'linear') return { mode, smooth: true, widths: [], steps: [] };
    return mode === 'falloff' && widths.some((each) => each > 0) ? { mode, smooth: isSmooth, widths, steps: [] } : undefined;
  };
  const dialog = showBeside(
    'Outside the lattice', 'outside',
    h('h2', {}, 'Outside the lattice'),
    modes.element, falloff, note,
    h('footer', {}, button('Cancel', () => dialog.close()), button('Change', change, { class: 'button primary' })));
  handles.onDragged = (side, dragged) => {
    widths = widths.map((each, other) => (other === side ? dragged : each));
    show();
  };
  const endLattice = session.on('lattice', () => dialog.close()); // it is another one
  dialog.addEventListener('close', () => {
    endLattice();
    handles.dispose();
  });
  onEnter(dialog, change);
  show();
  return () => dialog.close();
}

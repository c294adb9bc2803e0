// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks for a lattice to add to the scene. The view beside the dialog shows its box, with a handle on each face. The box has the
// axes of the lattice that is shown, or is turned against them.
import { placeInFrame } from '../../cage/outside_box';
import { rotated } from '../../edit/motion';
import { AXES, frameEdges } from '../../lattice/grid';
import { DEFAULT_FIT, latticeAtRest } from '../../lattice/identity';
import type { LatticeFrame } from '../../lattice/lattice';
import { add, scale, sub, type Vec3 } from '../../lattice/vec';
import type { LiveSession } from '../../session/live_session';
import type { OutsideHandles } from '../../viewport/outside_handles';
import { button, field } from '../controls';
import { h, onEnter, showBeside } from '../dom';
import { axesTable } from '../fields/axes_table';
import { numberField } from '../fields/number_field';
import { OutsideForm, type OutsideChoice } from '../fields/outside_form';

const FIRST = -0.25; // of each side: the middle half of the frame
const LEAST_EDGE = 0.02; // of the box, in lengths of the frame's edges

const NOTES: Record<OutsideChoice, string> = {
  fixed: 'The box must end outside the mesh. Where it ends inside, the mesh would tear.',
  falloff: 'Outside the box the move fades out. Widths are in lengths of its edges.',
  linear: 'The deformation goes on along straight lines, as far as the mesh reaches.',
};

/** How far a face of the box may be from that of the frame, in lengths of the frame's edges. */
export function allowedReach(reach: number): number {
  return Math.min(Math.max(reach, LEAST_EDGE - 1), 10);
}

/** The box that reaches so far beyond each side of a frame: the begin and end of u, of v, of w. Below 0: within it. */
export function boxAround(frame: LatticeFrame, reach: readonly number[]): LatticeFrame {
  const edge = (axis: 0 | 1 | 2): Vec3 => scale(frameEdges(frame)[axis], 1 + reach[2 * axis]! + reach[2 * axis + 1]!);
  const origin = placeInFrame(frame, [-reach[0]!, -reach[2]!, -reach[4]!]);
  return { origin, u: edge(0), v: edge(1), w: edge(2) };
}

/** The frame turned about its middle: about the world's x, then y, then z, in degrees. */
export function turnedFrame(frame: LatticeFrame, degrees: Vec3): LatticeFrame {
  const turned = (v: Vec3): Vec3 => AXES.reduce<Vec3>((at, axis) => {
    const about: [number, number, number] = [0, 0, 0];
    about[axis] = 1;
    return degrees[axis] === 0 ? at : rotated(about, degrees[axis] * (Math.PI / 180), at);
  }, v);
  const middle = placeInFrame(frame, [0.5, 0.5, 0.5]);
  const [u, v, w] = frameEdges(frame);
  return { origin: add(middle, turned(sub(frame.origin, middle))), u: turned(u), v: turned(v), w: turned(w) };
}

/** Returns a function that closes the dialog. */
export function showAddLatticeDialog(session: LiveSession, handles: OutsideHandles): () => void {
  const { frame } = session.lattice;
  const values = { size: DEFAULT_FIT.size, degree: DEFAULT_FIT.degree };
  const turn: [number, number, number] = [0, 0, 0];
  let reach: readonly number[] = new Array<number>(6).fill(FIRST);
  const turns = AXES.map((axis) => numberField(
    { label: `Turn about ${'xyz'[axis]}`, get: () => turn[axis], set: (degrees) => (turn[axis] = degrees) }, {
      min: -360, max: 360, step: 5, live: true,
      typed: () => {
        handles.moveTo(turnedFrame(frame, turn));
        check();
      },
    }));
  const confirm = button('Add', () => add(), { class: 'button primary' });
  const first = { mode: 'falloff', smooth: true, widths: new Array<number>(6).fill(0.5), steps: [] } as const;
  let hasAxes = true;
  const check = (): void => void (confirm.disabled = !hasAxes || !outside.isValid || turns.some((each) => !each.isValid()));
  const outside = new OutsideForm({ first, width: 0.5, notes: NOTES, changed: check });
  const table = axesTable(values, (isValid) => {
    hasAxes = isValid;
    check();
  });
  const problem = h('p', { class: 'note', role: 'alert' });
  const add = (): void => {
    if (confirm.disabled) return;
    confirm.disabled = true; // until the answer: a lattice that was added is shown, and ends the dialog
    problem.textContent = '';
    session.addLattice(latticeAtRest(boxAround(turnedFrame(frame, turn), reach), values.size, values.degree, outside.wanted));
  };
  const dialog = showBeside(
    'Add a lattice', 'add-lattice',
    h('h2', {}, 'Add a lattice'),
    table.element, table.note, field('Turn', ...turns.map(({ element }) => element), '°'), outside.element,
    h('p', { class: 'note' }, 'Drag the handles in the view to place the box. What all lattices move the mesh adds up.'),
    problem,
    h('footer', {}, button('Cancel', () => dialog.close()), confirm));
  handles.onDragged = (side, dragged) => {
    const opposite = reach[side ^ 1]!;
    reach = reach.map((each, other) => (other === side ? Math.max(dragged, LEAST_EDGE - 1 - opposite) : each));
    handles.show(reach, true);
  };
  const endLattice = session.on('lattice', () => dialog.close()); // it is another one
  const endRefused = session.on('refused', (text) => {
    problem.textContent = text;
    check();
  });
  dialog.addEventListener('close', () => {
    endLattice();
    endRefused();
    handles.dispose();
  });
  onEnter(dialog, add);
  handles.show(reach, true);
  return () => dialog.close();
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Command, CommandGroup } from '../commands';
import { button } from '../controls';
import { h, onEnter, showDialog } from '../dom';

const GROUPS: readonly CommandGroup[] = ['Transform', 'Select', 'View', 'Edit', 'File'];

/** Actions of the pointer. They, the arrow keys and the keys of a running transform below are no commands. */
const POINTER: readonly (readonly [string, string])[] = [
  ['Drag empty space', 'Orbit; right or two fingers: pan; wheel or pinch: zoom'],
  ['Click a point', 'Select; Shift adds, Ctrl toggles'],
  ['Drag a point', 'Move what is selected, in the plane of the view'],
  ['Drag a handle', 'Move, turn or scale along its axis or plane'],
  ['Shift + drag', 'Select by a box'],
];

const KEYBOARD: readonly (readonly [string, string])[] = [
  ['← → ↑ ↓', 'To the next control point; Shift adds it'],
  ['Ctrl + ↑ ↓', 'To the next one away from the eye, and back'],
  ['1/2  pi*2  +=0.1', 'In a field for a number; Enter applies, Esc restores'],
];

const WHILE_TRANSFORMING: readonly (readonly [string, string])[] = [
  ['X Y Z', 'Along one axis; again: of the lattice, or world; again: free'],
  ['Shift + X Y Z', 'In the plane across an axis'],
  ['R again', 'Trackball'],
  ['0–9 . - ⌫', 'Type the amount'],
  ['Tab', 'The next number: G 1 Tab 2 Tab 3'],
  ['Wheel, PgUp/PgDn', 'Reach of soft selection; O: on or off'],
  ['Shift / Ctrl', 'Fine / snap'],
  ['Enter, click', 'Confirm'],
  ['Esc, right click', 'Cancel'],
];

const FILES: readonly (readonly [string, string])[] = [
  ['OBJ', 'With its MTL file and pictures, dropped together'],
  ['PLY', 'With the pictures that it names in comments: TextureFile'],
  ['GLB', 'With its own pictures, or those dropped with it'],
  ['Pictures', 'Stay in this browser, with the mesh; others see those inside a GLB'],
  ['STL DRC', 'Shown without pictures'],
  ['JSON', 'A lattice, as latticectl lattice writes it'],
];

export function showHelp(commands: readonly Command[]): void {
  const sections = GROUPS.map((group) => {
    const rows = commands.filter((c) => c.group === group && c.keys !== undefined);
    return section(group, rows.map((c) => [c.keys![0], c.label] as const));
  });
  const close = button('Close', () => dialog.close());
  const dialog = showDialog(
    'Keys',
    'help',
    h('header', {}, h('h2', {}, 'Keys'), h('a', { href: 'docs/', target: '_blank' }, 'Documentation'), close),
    h(
      'div',
      { class: 'help-scroll', tabindex: 0, autofocus: true }, // so that arrow keys scroll
      h(
        'div',
        { class: 'help-columns' },
        section('Pointer', POINTER),
        section('Keyboard', KEYBOARD),
        section('During G, R, S', WHILE_TRANSFORMING),
        sections[0],
        section('Dropped files', FILES),
        ...sections.slice(1),
      ),
    ),
  );
  onEnter(dialog, () => dialog.close());
}

function section(title: string, rows: readonly (readonly [string, string])[]): HTMLElement {
  const items = rows.flatMap(([keys, text]) => [h('dt', {}, h('kbd', {}, keys)), h('dd', {}, text)]);
  return h('section', {}, h('h3', {}, title), h('dl', {}, ...items));
}

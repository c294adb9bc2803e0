// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Editor } from '../edit/editor';
import { AXIS_NAMES, type Axis } from '../lattice/grid';
import type { Command } from '../ui/commands';
import { makersOf, type CommandTarget } from './command_makers';

export function selectCommands(app: CommandTarget): Command[] {
  const { onScene, onOff, tool } = makersOf(app, 'Select');
  const lines = AXIS_NAMES.flatMap((name, axis) => {
    const key = name.toUpperCase();
    return [
      onScene(`row-${name}`, `Row along ${name}`, ({ editor }) => editor.selectRows(axis as Axis, false), { keys: [key] }),
      onScene(`plane-${name}`, `Plane across ${name}`, ({ editor }) => editor.selectRows(axis as Axis, true), { keys: [`Shift+${key}`] }),
    ];
  });
  const hide = ({ selection }: Editor): void => selection.hide(selection.indices);
  return [
    onScene('select-all', 'All', ({ editor }) => editor.selection.all(), { keys: ['A'], icon: 'all' }),
    onScene('select-none', 'None', ({ editor }) => leave(app, editor), { keys: ['Alt+A', 'Escape'], icon: 'none' }),
    onScene('select-invert', 'Invert', ({ editor }) => editor.selection.invert(), { keys: ['Ctrl+I'], icon: 'invert' }),
    ...lines,
    onScene('hide', 'Hide selected', ({ editor }) => hide(editor), { keys: ['H'], icon: 'eyeOff' }),
    onScene('hide-inner', 'Hide inner points', ({ editor }) => editor.hideInner(), { keys: ['Shift+H'] }),
    onScene('reveal', 'Show hidden', ({ editor }) => editor.selection.reveal(), { keys: ['Alt+H'], icon: 'eye' }),
    onOff('toggling', 'Add and take out, one by one', { icon: 'extend' }),
    onOff('through', 'Through the surface', { keys: ['Alt+Z'], icon: 'through' }),
    tool('select', 'Select', 'Q', 'select'),
    tool('box', 'Select by a box', 'B', 'box'),
  ];
}

/** Out of a tool first, then of the selection. */
function leave({ settings }: CommandTarget, { selection }: Editor): void {
  if (settings.value.tool === 'select') selection.none();
  else settings.set({ tool: 'select' });
}

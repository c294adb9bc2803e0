// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Editor } from '../edit/editor';
import { AXIS_NAMES, type Axis } from '../lattice/grid';
import type { SceneView } from '../scene_view';
import type { Command } from '../ui/commands';
import { onOff, onScene, tool, type CommandTarget } from './command_makers';

export function selectCommands(app: CommandTarget): Command[] {
  const selection = (
    id: string,
    label: string,
    run: (scene: SceneView) => void,
    more: Partial<Command> = {},
  ): Command => onScene(app, 'Select', id, label, run, more);
  const lines = AXIS_NAMES.flatMap((name, axis) => [
    selection(`row-${name}`, `Row along ${name}`, ({ editor }) => editor.selectRows(axis as Axis, false), {
      keys: [name.toUpperCase()],
    }),
    selection(`plane-${name}`, `Plane across ${name}`, ({ editor }) => editor.selectRows(axis as Axis, true), {
      keys: [`Shift+${name.toUpperCase()}`],
    }),
  ]);
  return [
    selection('select-all', 'All', ({ editor }) => editor.selection.all(), { keys: ['A'], icon: 'all' }),
    selection('select-none', 'None', ({ editor }) => leave(app, editor), {
      keys: ['Alt+A', 'Escape'],
      icon: 'none',
    }),
    selection('select-invert', 'Invert', ({ editor }) => editor.selection.invert(), {
      keys: ['Ctrl+I'],
      icon: 'invert',
    }),
    ...lines,
    selection('hide', 'Hide selected', ({ editor }) => editor.selection.hide(editor.selection.indices), {
      keys: ['H'],
      icon: 'eyeOff',
    }),
    selection('hide-inner', 'Hide inner points', ({ editor }) => editor.hideInner(), { keys: ['Shift+H'] }),
    selection('reveal', 'Show hidden', ({ editor }) => editor.selection.reveal(), { keys: ['Alt+H'], icon: 'eye' }),
    onOff(app, 'Select', 'toggling', 'Add and take out, one by one', { icon: 'extend' }),
    onOff(app, 'Select', 'through', 'Through the surface', { keys: ['Alt+Z'], icon: 'through' }),
    tool(app, 'select', 'Select', ['Q'], 'select'),
    tool(app, 'box', 'Select by a box', ['B'], 'box'),
  ];
}

/** Out of a tool first, then of the selection. */
function leave({ settings }: CommandTarget, { selection }: Editor): void {
  if (settings.value.tool === 'select') selection.none();
  else settings.set({ tool: 'select' });
}

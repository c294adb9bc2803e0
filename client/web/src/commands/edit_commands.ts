// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Command } from '../ui/commands';
import { showKnotDialog } from '../ui/knot_dialog';
import { onScene, type CommandTarget } from './command_makers';

export function editCommands(app: CommandTarget): Command[] {
  return [
    onScene(app, 'Edit', 'undo', 'Undo', ({ session }) => session.undo(), { keys: ['Ctrl+Z'], icon: 'undo' }),
    onScene(app, 'Edit', 'redo', 'Redo', ({ session }) => session.redo(), {
      keys: ['Ctrl+Shift+Z', 'Ctrl+Y'],
      icon: 'redo',
    }),
    onScene(app, 'Edit', 'reset', 'Reset to rest', ({ session }) => session.reset('identity'), { icon: 'reset' }),
    onScene(app, 'Edit', 'reset-initial', 'Reset to the first lattice', ({ session }) => session.reset('initial')),
    onScene(app, 'Edit', 'knot', 'Insert knot plane…', ({ editor }) => showKnotDialog(editor), {
      keys: ['K'],
      icon: 'knot',
    }),
  ];
}

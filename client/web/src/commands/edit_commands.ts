// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Command } from '../ui/commands';
import { showKnotDialog } from '../ui/dialogs/knot_dialog';
import { makersOf, type CommandTarget } from './command_makers';

export function editCommands(app: CommandTarget): Command[] {
  const { onScene } = makersOf(app, 'Edit');
  return [
    onScene('undo', 'Undo', ({ session }) => session.undo(), { keys: ['Ctrl+Z'], icon: 'undo' }),
    onScene('redo', 'Redo', ({ session }) => session.redo(), { keys: ['Ctrl+Shift+Z', 'Ctrl+Y'], icon: 'redo' }),
    onScene('reset', 'Reset to rest', ({ session }) => session.reset('identity'), { icon: 'reset' }),
    onScene('reset-initial', 'Reset to the first lattice', ({ session }) => session.reset('initial')),
    onScene('knot', 'Insert knot plane…', ({ editor }) => showKnotDialog(editor), { keys: ['K'], icon: 'knot' }),
  ];
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What can be done, by name and key: a file per menu.
import type { Command } from '../ui/commands';
import type { CommandTarget } from './command_makers';
import { editCommands } from './edit_commands';
import { fileCommands } from './file_commands';
import { selectCommands } from './select_commands';
import { transformCommands } from './transform_commands';
import { viewCommands } from './view_commands';

export function makeCommands(app: CommandTarget): Command[] {
  return [
    ...fileCommands(app),
    ...editCommands(app),
    ...selectCommands(app),
    ...transformCommands(app),
    ...viewCommands(app),
  ];
}

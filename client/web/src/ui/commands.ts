// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// All commands, each defined once. Toolbar, menus, keys and the help overlay all use this list.
import type { IconName } from './icons';

export type CommandGroup = 'File' | 'Edit' | 'Select' | 'Transform' | 'View';

export interface Command {
  readonly id: string;
  readonly label: string;
  readonly group: CommandGroup;
  /** Chords, for example "Ctrl+Z", "Shift+H", "G", "?". The first one is shown. */
  readonly keys?: readonly string[];
  readonly icon?: IconName;
  run(): void;
  /** Whether it is on; absent for a command that is no switch. */
  checked?(): boolean;
  /** Absent: always enabled. */
  enabled?(): boolean;
  /** Whether it would change nothing now, as far as the page knows. Its buttons are grey; its key still runs it. */
  idle?(): boolean;
}

/** Whether a command's buttons are grey. */
export function isGrey({ enabled, idle }: Command): boolean {
  return enabled?.() === false || idle?.() === true;
}

type KeyPress = Pick<KeyboardEvent, 'key' | 'code' | 'ctrlKey' | 'metaKey' | 'altKey' | 'shiftKey'>;

/**
 * The upper-case letter of a key press, by the keyboard's layout. For layouts without Latin letters, and for signs that
 * Alt types, it is the letter at the key's place on a US keyboard.
 */
export function letterOf({ key, code }: Pick<KeyboardEvent, 'key' | 'code'>): string | undefined {
  if (/^[a-z]$/i.test(key)) return key.toUpperCase();
  return /^[ -~]$/.test(key) ? undefined : /^Key([A-Z])$/.exec(code)?.[1]; // on Dvorak "." is at the place of E
}

/** The chord of a key press. Letters are upper case. Cmd counts as Ctrl. For other signs Shift is part of the sign. */
export function chordOf(event: KeyPress): string {
  const letter = letterOf(event);
  const digit = /^(?:Digit|Numpad)([0-9])$/.exec(event.code)?.[1];
  const key = letter ?? digit ?? event.key;
  const shown = letter !== undefined || digit !== undefined || key.length > 1;
  const parts = [
    (event.ctrlKey || event.metaKey) && 'Ctrl',
    event.altKey && 'Alt',
    event.shiftKey && shown && 'Shift',
    key,
  ];
  return parts.filter((part) => part !== false).join('+');
}

export class Commands {
  private readonly byId = new Map<string, Command>();
  private readonly byKey = new Map<string, Command>();

  constructor(readonly list: readonly Command[]) {
    for (const command of list) {
      this.byId.set(command.id, command);
      for (const key of command.keys ?? []) this.byKey.set(key, command);
    }
  }

  get(id: string): Command {
    const command = this.byId.get(id);
    if (command === undefined) throw new Error(`No command ${id}`);
    return command;
  }

  /** Runs the command of a key press. Returns whether there was one. */
  press(event: KeyPress): boolean {
    const command = this.byKey.get(chordOf(event));
    if (command === undefined || command.enabled?.() === false) return false;
    command.run();
    return true;
  }
}

/** A command's label and key, for tooltips. */
export function tooltip({ label, keys }: Command): string {
  return keys === undefined ? label : `${label} (${keys[0]})`;
}

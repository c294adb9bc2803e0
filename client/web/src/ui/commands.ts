// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Everything that can be done, once: the toolbar's buttons, the keys and the help overlay all come from this list.
import type { IconName } from './icons';

export type CommandGroup = 'File' | 'Edit' | 'Select' | 'Transform' | 'View';

export interface Command {
  readonly id: string;
  readonly label: string;
  readonly group: CommandGroup;
  /** Chords such as "Ctrl+Z", "Shift+H", "G", "?"; the first one is shown. */
  readonly keys?: readonly string[];
  readonly icon?: IconName;
  run(): void;
  /** For what is on or off. */
  checked?(): boolean;
  /** Absent: always. */
  enabled?(): boolean;
}

type KeyPress = Pick<KeyboardEvent, 'key' | 'code' | 'ctrlKey' | 'metaKey' | 'altKey' | 'shiftKey'>;

/**
 * The letter of a key press, upper case: what the keyboard's layout makes of the key or, of layouts without Latin letters
 * and of Alt's signs, what stands at its place on a US keyboard.
 */
export function letterOf({ key, code }: Pick<KeyboardEvent, 'key' | 'code'>): string | undefined {
  if (/^[a-z]$/i.test(key)) return key.toUpperCase();
  return /^[ -~]$/.test(key) ? undefined : /^Key([A-Z])$/.exec(code)?.[1]; // on Dvorak . stands at the place of E
}

/** The chord of a key press. Letters are upper case; Cmd counts as Ctrl; of other signs Shift is part of the sign. */
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

  /** Runs what a key press means; says whether it meant anything. */
  press(event: KeyPress): boolean {
    const command = this.byKey.get(chordOf(event));
    if (command === undefined || command.enabled?.() === false) return false;
    command.run();
    return true;
  }
}

/** A command's name and key, for tooltips. */
export function tooltip({ label, keys }: Command): string {
  return keys === undefined ? label : `${label} (${keys[0]})`;
}

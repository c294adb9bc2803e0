// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Commands that come in kinds: on the open scene, of a setting, of a tool.
import type { SceneOpener } from '../scene_opener';
import type { SceneView } from '../scene_view';
import type { Settings } from '../state/settings';
import type { Command, CommandGroup, Commands } from '../ui/commands';
import type { IconName } from '../ui/icons';
import type { Workspace } from '../workspace';

/** The page, as commands see it. */
export interface CommandTarget extends Workspace {
  readonly opener: SceneOpener;
  readonly commands: Commands;
}

type More = Partial<Command>;

/** What makes commands of one menu. */
export interface Makers {
  /** A command on the open scene, which waits for one. */
  onScene(id: string, label: string, run: (scene: SceneView) => void, more?: More): Command;
  /** A command that turns a setting on and off. */
  onOff(key: keyof Settings & string, label: string, more?: More): Command;
  tool(name: Settings['tool'], label: string, key: string, icon: IconName): Command;
}

export function makersOf(app: CommandTarget, group: CommandGroup): Makers {
  const { settings } = app;
  const isOpen = (): boolean => app.scene !== undefined;
  return {
    onScene: (id, label, run, more) =>
      ({ id, label, group, run: () => app.scene !== undefined && run(app.scene), enabled: isOpen, ...more }),
    onOff: (key, label, more) => ({
      id: key, label, group, run: () => settings.set({ [key]: !settings.value[key] }), checked: () => settings.value[key] === true, ...more,
    }),
    tool: (name, label, key, icon) => {
      const isOn = (): boolean => settings.value.tool === name;
      // Pressed again, a tool gives way to the plain pointer.
      return { id: `tool-${name}`, label, group, keys: [key], icon, run: () => settings.set({ tool: isOn() ? 'select' : name }), checked: isOn };
    },
  };
}

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

/** A command on the open scene, which waits for one. */
export function onScene(
  app: CommandTarget,
  group: CommandGroup,
  id: string,
  label: string,
  run: (scene: SceneView) => void,
  more: Partial<Command> = {},
): Command {
  return {
    id,
    label,
    group,
    run: () => app.scene !== undefined && run(app.scene),
    enabled: () => app.scene !== undefined,
    ...more,
  };
}

/** A command that turns a setting on and off. */
export function onOff(
  app: CommandTarget,
  group: CommandGroup,
  key: keyof Settings & string,
  label: string,
  more: Partial<Command> = {},
): Command {
  const { settings } = app;
  return {
    id: key,
    label,
    group,
    run: () => settings.set({ [key]: !settings.value[key] }),
    checked: () => settings.value[key] === true,
    ...more,
  };
}

export function tool(app: CommandTarget, name: Settings['tool'], label: string, keys: string[], icon: IconName): Command {
  const { settings } = app;
  // Pressed again, a tool gives way to the plain pointer.
  const run = (): void => settings.set({ tool: settings.value.tool === name ? 'select' : name });
  return {
    id: `tool-${name}`,
    label,
    group: name === 'pull' ? 'Transform' : 'Select',
    keys,
    icon,
    run,
    checked: () => settings.value.tool === name,
  };
}

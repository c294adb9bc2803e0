// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from '../lattice/vec';
import type { Command } from '../ui/commands';
import { showHelp } from '../ui/help';
import type { IconName } from '../ui/icons';
import { onOff, onScene, type CommandTarget } from './command_makers';

export function viewCommands(app: CommandTarget): Command[] {
  const { viewport, settings } = app;
  const look = (id: string, label: string, from: Vec3, key: string, icon?: IconName): Command => ({
    id,
    label,
    group: 'View',
    keys: [key],
    icon,
    run: () => viewport.rig.lookFrom(from),
  });
  const nextTheme = { system: 'dark', dark: 'light', light: 'system' } as const;
  return [
    onScene(app, 'View', 'frame-all', 'Frame all', (scene) => scene.frameAll(), { keys: ['Home'] }),
    onScene(app, 'View', 'frame-selected', 'Frame selected', (scene) => scene.frameSelected(), {
      keys: ['F'],
      icon: 'frame',
    }),
    look('view-front', 'Front', [0, -1, 0], '1', 'front'),
    look('view-side', 'Side', [1, 0, 0], '3', 'side'),
    look('view-top', 'Top', [0, 0, 1], '7', 'top'),
    look('view-back', 'Back', [0, 1, 0], 'Ctrl+1'),
    look('view-left', 'Other side', [-1, 0, 0], 'Ctrl+3'),
    look('view-bottom', 'Bottom', [0, 0, -1], 'Ctrl+7'),
    onOff(app, 'View', 'orthographic', 'Orthographic', { keys: ['5'], icon: 'ortho' }),
    onOff(app, 'View', 'wireframe', 'Wireframe', { keys: ['Z'], icon: 'wire' }),
    onOff(app, 'View', 'patchEdges', 'Patch edges', { keys: ['E'] }),
    onOff(app, 'View', 'ghost', 'Rest shape', { keys: ['T'] }),
    onOff(app, 'View', 'knotBoxes', 'Box edges', { keys: ['J'] }),
    onOff(app, 'View', 'cage', 'Cage', { keys: ['C'], icon: 'lattice' }),
    onOff(app, 'View', 'panel', 'Side panel', { keys: ['N'], icon: 'panel', enabled: () => app.scene !== undefined }),
    {
      id: 'theme',
      label: 'Theme: system, dark, light',
      group: 'View',
      icon: 'theme',
      run: () => settings.set({ theme: nextTheme[settings.value.theme] }),
    },
    { id: 'help', label: 'Keys', group: 'View', keys: ['?'], icon: 'help', run: () => showHelp(app.commands.list) },
  ];
}

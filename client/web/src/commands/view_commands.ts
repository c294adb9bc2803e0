// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from '../lattice/vec';
import type { Command } from '../ui/commands';
import { showHelp } from '../ui/dialogs/help';
import type { IconName } from '../ui/icons';
import { makersOf, type CommandTarget } from './command_makers';

export function viewCommands(app: CommandTarget): Command[] {
  const { viewport, settings } = app;
  const { onScene, onOff } = makersOf(app, 'View');
  const look = (id: string, label: string, from: Vec3, key: string, icon?: IconName): Command =>
    ({ id, label, group: 'View', keys: [key], icon, run: () => viewport.rig.lookFrom(from) });
  const nextTheme = { system: 'dark', dark: 'light', light: 'system' } as const;
  const turnTheme = (): void => settings.set({ theme: nextTheme[settings.value.theme] });
  return [
    onScene('frame-all', 'Frame all', (scene) => scene.frameAll(), { keys: ['Home'] }),
    onScene('frame-selected', 'Frame selected', (scene) => scene.frameSelected(), { keys: ['F'], icon: 'frame' }),
    look('view-front', 'Front', [0, -1, 0], '1', 'front'),
    look('view-side', 'Side', [1, 0, 0], '3', 'side'),
    look('view-top', 'Top', [0, 0, 1], '7', 'top'),
    look('view-back', 'Back', [0, 1, 0], 'Ctrl+1'),
    look('view-left', 'Other side', [-1, 0, 0], 'Ctrl+3'),
    look('view-bottom', 'Bottom', [0, 0, -1], 'Ctrl+7'),
    onOff('orthographic', 'Orthographic', { keys: ['5'], icon: 'ortho' }),
    onOff('wireframe', 'Wireframe', { keys: ['Z'], icon: 'wire' }),
    onOff('patchEdges', 'Patch edges', { keys: ['E'] }),
    onOff('ghost', 'Rest shape', { keys: ['T'] }),
    onOff('knotBoxes', 'Box edges', { keys: ['J'] }),
    onOff('cage', 'Cage', { keys: ['C'], icon: 'lattice' }),
    onOff('panel', 'Side panel', { keys: ['N'], icon: 'panel', enabled: () => app.scene !== undefined }),
    { id: 'theme', label: 'Theme: system, dark, light', group: 'View', icon: 'theme', run: turnTheme },
    { id: 'help', label: 'Keys', group: 'View', keys: ['?'], icon: 'help', run: () => showHelp(app.commands.list) },
  ];
}

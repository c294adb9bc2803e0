// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { MotionKind } from '../edit/motion';
import { AXIS_NAMES, type Axis } from '../lattice/grid';
import type { Settings } from '../state/settings';
import type { Command } from '../ui/commands';
import { makersOf, type CommandTarget } from './command_makers';

export function transformCommands(app: CommandTarget): Command[] {
  const { settings, toasts } = app;
  const { onScene, tool } = makersOf(app, 'Transform');
  const begin = (kind: MotionKind, label: string, key: string): Command =>
    onScene(kind, label, (scene) => {
      if (!scene.beginTransform(kind)) toasts.tell('Select control points first: click one, or A for all.');
    }, { keys: [key] });
  const handles = (kind: MotionKind, label: string): Command => {
    const isOn = (): boolean => settings.value.gizmo === kind;
    const run = (): void => settings.set({ gizmo: isOn() ? 'none' : kind, tool: 'select' });
    return { id: `gizmo-${kind}`, label, group: 'Transform', icon: kind, run, checked: isOn };
  };
  const resize = (id: string, label: string, keys: string[], steps: number): Command =>
    onScene(id, label, ({ editor }) => editor.resizeSoft(steps), { keys });
  const soft = (): Settings['soft'] => settings.value.soft;
  return [
    begin('move', 'Move', 'G'),
    begin('rotate', 'Rotate', 'R'),
    begin('scale', 'Scale', 'S'),
    tool('pull', 'Pull the surface', 'P', 'pull'),
    handles('move', 'Move handles'),
    handles('rotate', 'Rotate handles'),
    handles('scale', 'Scale handles'),
    cycle(app, 'orientation', 'Next axes', ',', ['world', 'lattice', 'view']),
    cycle(app, 'pivot', 'Next pivot', '.', ['median', 'active', 'each']),
    {
      id: 'soft', label: 'Soft selection', group: 'Transform', keys: ['O'], icon: 'soft',
      run: () => settings.set({ soft: { ...soft(), enabled: !soft().enabled } }),
      checked: () => soft().enabled,
    },
    resize('soft-smaller', 'Smaller soft radius', ['[', 'PageDown'], -1),
    resize('soft-larger', 'Larger soft radius', [']', 'PageUp'], 1),
    ...AXIS_NAMES.map((name, axis) => mirror(app, name, axis as Axis)),
  ];
}

function mirror({ settings }: CommandTarget, name: string, axis: Axis): Command {
  const run = (): void => {
    const mirror = [...settings.value.mirror] as [boolean, boolean, boolean];
    mirror[axis] = !mirror[axis];
    settings.set({ mirror });
  };
  return {
    id: `mirror-${name}`,
    label: `Mirror over ${name}`,
    group: 'Transform',
    keys: [`Alt+${name.toUpperCase()}`],
    run,
    checked: () => settings.value.mirror[axis],
  };
}

function cycle<K extends 'orientation' | 'pivot'>(
  { settings }: CommandTarget,
  key: K,
  label: string,
  chord: string,
  values: readonly Settings[K][],
): Command {
  const run = (): void => {
    const next = (values.indexOf(settings.value[key]) + 1) % values.length;
    settings.set({ [key]: values[next] });
  };
  return { id: `cycle-${key}`, label, group: 'Transform', keys: [chord], run };
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What can be done, by name and key.
import type { App } from './app';
import type { MotionKind } from './edit/motion';
import { MESH_ENDINGS } from './intake/mesh_file';
import { EXPORT_FORMATS } from './intake/services';
import { AXIS_NAMES, type Axis } from './lattice/grid';
import type { Vec3 } from './lattice/vec';
import type { SceneView } from './scene_view';
import type { Settings } from './state/settings';
import type { Command, CommandGroup } from './ui/commands';
import { showExportDialog } from './ui/export_dialog';
import { showHelp } from './ui/help';
import type { IconName } from './ui/icons';
import { showKnotDialog } from './ui/knot_dialog';
import { chooseFiles } from './ui/start_screen';

export function makeCommands(app: App): Command[] {
  return [...fileCommands(app), ...editCommands(app), ...selectCommands(app), ...transformCommands(app), ...viewCommands(app)];
}

/** A command on the open scene, which waits for one. */
function onScene(app: App, group: CommandGroup, id: string, label: string, run: (scene: SceneView) => void, more: Partial<Command> = {}): Command {
  return { id, label, group, run: () => app.scene !== undefined && run(app.scene), enabled: () => app.scene !== undefined, ...more };
}

/** A command that turns a setting on and off. */
function onOff(app: App, group: CommandGroup, key: keyof Settings & string, label: string, more: Partial<Command> = {}): Command {
  const { settings } = app;
  return { id: key, label, group, run: () => settings.set({ [key]: !settings.value[key] }), checked: () => settings.value[key] === true, ...more };
}

function fileCommands(app: App): Command[] {
  const open = (accept: string) => () => chooseFiles(accept, (files) => app.opener.takeFiles(files));
  return [
    { id: 'open', label: 'Open mesh…', group: 'File', keys: ['Ctrl+O'], icon: 'open', run: open(MESH_ENDINGS) },
    ...(['knot', 'vase', 'slab'] as const).map(
      (name): Command => ({ id: `sample-${name}`, label: `Sample: ${name}`, group: 'File', icon: 'sample', run: () => app.opener.takeSample(name) }),
    ),
    onScene(app, 'File', 'open-lattice', 'Open lattice…', open('.json'), { icon: 'load' }),
    onScene(app, 'File', 'save-lattice', 'Save lattice', () => app.opener.saveLattice(), { keys: ['Ctrl+S'], icon: 'save' }),
    onScene(app, 'File', 'export', 'Export…', ({ session }) => showExportDialog(EXPORT_FORMATS, (f) => app.services.exportAddress(session.sceneId, f)), {
      keys: ['Ctrl+E'],
      icon: 'export',
    }),
    onScene(app, 'File', 'share', 'Copy link to this scene', () => void copyLink(app), { icon: 'share' }),
  ];
}

/** Without the address's fragment, which may hold this person's token. */
async function copyLink(app: App): Promise<void> {
  const link = location.origin + location.pathname + location.search;
  try {
    await navigator.clipboard.writeText(link);
    app.toasts.tell('The link is copied. Who opens it edits the same scene.');
  } catch {
    app.toasts.tell(`Copy this link: ${link}`); // no clipboard without https
  }
}

function editCommands(app: App): Command[] {
  return [
    onScene(app, 'Edit', 'undo', 'Undo', ({ session }) => session.undo(), { keys: ['Ctrl+Z'], icon: 'undo' }),
    onScene(app, 'Edit', 'redo', 'Redo', ({ session }) => session.redo(), { keys: ['Ctrl+Shift+Z', 'Ctrl+Y'], icon: 'redo' }),
    onScene(app, 'Edit', 'reset', 'Reset to rest', ({ session }) => session.reset('identity'), { icon: 'reset' }),
    onScene(app, 'Edit', 'reset-initial', 'Reset to the first lattice', ({ session }) => session.reset('initial')),
    onScene(app, 'Edit', 'knot', 'Insert knot plane…', ({ editor }) => showKnotDialog(editor), { keys: ['K'], icon: 'knot' }),
  ];
}

function selectCommands(app: App): Command[] {
  const selection = (id: string, label: string, run: (scene: SceneView) => void, more: Partial<Command> = {}): Command =>
    onScene(app, 'Select', id, label, run, more);
  const lines = AXIS_NAMES.flatMap((name, axis) => [
    selection(`row-${name}`, `Row along ${name}`, ({ editor }) => editor.selectRows(axis as Axis, false), { keys: [name.toUpperCase()] }),
    selection(`plane-${name}`, `Plane across ${name}`, ({ editor }) => editor.selectRows(axis as Axis, true), { keys: [`Shift+${name.toUpperCase()}`] }),
  ]);
  return [
    selection('select-all', 'All', ({ editor }) => editor.selection.all(), { keys: ['A'], icon: 'all' }),
    selection('select-none', 'None', ({ editor }) => editor.selection.none(), { keys: ['Alt+A', 'Escape'], icon: 'none' }),
    selection('select-invert', 'Invert', ({ editor }) => editor.selection.invert(), { keys: ['Ctrl+I'], icon: 'invert' }),
    ...lines,
    selection('hide', 'Hide selected', ({ editor }) => editor.selection.hide(editor.selection.indices), { keys: ['H'], icon: 'eyeOff' }),
    selection('hide-inner', 'Hide inner points', ({ editor }) => editor.hideInner(), { keys: ['Shift+H'] }),
    selection('reveal', 'Show hidden', ({ editor }) => editor.selection.reveal(), { keys: ['Alt+H'], icon: 'eye' }),
    onOff(app, 'Select', 'through', 'Through the surface', { keys: ['Alt+Z'], icon: 'through' }),
    tool(app, 'select', 'Select', ['Q'], 'select'),
    tool(app, 'box', 'Select by a box', ['B'], 'box'),
  ];
}

function tool(app: App, name: Settings['tool'], label: string, keys: string[], icon: IconName): Command {
  const { settings } = app;
  // Pressed again, a tool gives way to the plain pointer.
  const run = (): void => settings.set({ tool: settings.value.tool === name ? 'select' : name });
  return { id: `tool-${name}`, label, group: name === 'pull' ? 'Transform' : 'Select', keys, icon, run, checked: () => settings.value.tool === name };
}

function transformCommands(app: App): Command[] {
  const { settings } = app;
  const begin = (kind: MotionKind, label: string, key: string): Command =>
    onScene(app, 'Transform', kind, label, (scene) => {
      if (!scene.beginTransform(kind)) app.toasts.tell('Select control points first: click one, or A for all.');
    }, { keys: [key] });
  const handles = (kind: MotionKind, label: string): Command => ({
    id: `gizmo-${kind}`,
    label,
    group: 'Transform',
    icon: kind,
    run: () => settings.set({ gizmo: settings.value.gizmo === kind ? 'none' : kind, tool: 'select' }),
    checked: () => settings.value.gizmo === kind,
  });
  const resize = (factor: number) => (): void => settings.set({ soft: { ...settings.value.soft, radius: settings.value.soft.radius * factor } });
  return [
    begin('move', 'Move', 'G'),
    begin('rotate', 'Rotate', 'R'),
    begin('scale', 'Scale', 'S'),
    tool(app, 'pull', 'Pull the surface', ['P'], 'pull'),
    handles('move', 'Move handles'),
    handles('rotate', 'Rotate handles'),
    handles('scale', 'Scale handles'),
    cycle(app, 'orientation', 'Next axes', ',', ['world', 'lattice', 'view']),
    cycle(app, 'pivot', 'Next pivot', '.', ['median', 'active', 'each']),
    {
      id: 'soft',
      label: 'Soft selection',
      group: 'Transform',
      keys: ['O'],
      icon: 'soft',
      run: () => settings.set({ soft: { ...settings.value.soft, enabled: !settings.value.soft.enabled } }),
      checked: () => settings.value.soft.enabled,
    },
    { id: 'soft-smaller', label: 'Smaller soft radius', group: 'Transform', keys: ['['], run: resize(1 / 1.2) },
    { id: 'soft-larger', label: 'Larger soft radius', group: 'Transform', keys: [']'], run: resize(1.2) },
    ...AXIS_NAMES.map((name, axis) => mirror(app, name, axis as Axis)),
  ];
}

function mirror({ settings }: App, name: string, axis: Axis): Command {
  const run = (): void => {
    const mirror = [...settings.value.mirror] as [boolean, boolean, boolean];
    mirror[axis] = !mirror[axis];
    settings.set({ mirror });
  };
  return { id: `mirror-${name}`, label: `Mirror over ${name}`, group: 'Transform', keys: [`Alt+${name.toUpperCase()}`], run, checked: () => settings.value.mirror[axis] };
}

function cycle<K extends 'orientation' | 'pivot'>({ settings }: App, key: K, label: string, chord: string, values: readonly Settings[K][]): Command {
  const run = (): void => {
    const next = (values.indexOf(settings.value[key]) + 1) % values.length;
    settings.set({ [key]: values[next] });
  };
  return { id: `cycle-${key}`, label, group: 'Transform', keys: [chord], run };
}

function viewCommands(app: App): Command[] {
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
    onScene(app, 'View', 'frame-selected', 'Frame selected', (scene) => scene.frameSelected(), { keys: ['F'], icon: 'frame' }),
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
    onOff(app, 'View', 'panel', 'Side panel', { keys: ['N'], icon: 'panel' }),
    { id: 'theme', label: 'Theme: system, dark, light', group: 'View', icon: 'theme', run: () => settings.set({ theme: nextTheme[settings.value.theme] }) },
    { id: 'help', label: 'Keys', group: 'View', keys: ['?'], icon: 'help', run: () => showHelp(app.commands.list) },
  ];
}

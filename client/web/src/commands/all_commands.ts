// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// All commands with names and keys, menu by menu.
import { MESH_ENDINGS } from '../intake/mesh_file';
import { SAMPLES, type SampleName } from '../intake/samples';
import { EXPORT_FORMATS } from '../intake/services';
import { switchedMirror } from '../edit/mirror';
import { AXIS_NAMES, type Axis } from '../lattice/grid';
import type { Vec3 } from '../lattice/vec';
import { LIGHTS } from '../light/shading';
import type { PeopleHere } from '../people_here';
import type { SceneOpener } from '../scene_opener';
import type { SceneView } from '../scene_view';
import type { Settings } from '../state/settings';
import { lengthsInWords } from '../state/units';
import type { Command, CommandGroup, Commands } from '../ui/commands';
import { showExportDialog } from '../ui/dialogs/export_dialog';
import { showHelp } from '../ui/dialogs/help';
import { showShareDialog } from '../ui/dialogs/share_dialog';
import { chooseFiles } from '../ui/dialogs/start_screen';
import type { IconName } from '../ui/icons';
import { downloadExport } from '../wire/export_download';
import { SceneShares } from '../wire/scene_shares';
import type { Workspace } from '../workspace';

/** The page as commands see it. */
export interface CommandTarget extends Workspace {
  readonly opener: SceneOpener;
  readonly people: PeopleHere;
  readonly commands: Commands;
}

type More = Partial<Command>;

export function makeCommands(app: CommandTarget): Command[] {
  return [...fileCommands(app), ...editCommands(app), ...selectCommands(app), ...transformCommands(app), ...viewCommands(app)];
}

/** Makes the commands of one menu. */
class Makers {
  constructor(private readonly app: CommandTarget, private readonly group: CommandGroup) {}

  /** A command that needs no scene. */
  readonly always = (id: string, label: string, run: () => void, more?: More): Command => ({ id, label, group: this.group, run, ...more });

  /** A command on the open scene; disabled without one. */
  readonly onScene = (id: string, label: string, run: (scene: SceneView) => void, more?: More): Command =>
    this.always(id, label, () => this.app.scene !== undefined && run(this.app.scene), { enabled: () => this.app.scene !== undefined, ...more });

  /** A command that edits the open scene; disabled also where the token only allows to watch. */
  readonly onEditable = (id: string, label: string, run: (scene: SceneView) => void, more?: More): Command =>
    this.onScene(id, label, run, { enabled: () => this.app.scene?.session.mayEdit === true, ...more });

  /** A command that switches a setting on and off. */
  readonly onOff = (key: keyof Settings & string, label: string, more?: More): Command => {
    const { settings } = this.app;
    const checked = (): boolean => settings.value[key] === true;
    return this.always(key, label, () => settings.set({ [key]: !checked() }), { checked, ...more });
  };

  /** A command that goes to the next value of a setting. */
  readonly cycle = <K extends keyof Settings>(key: K, values: readonly Settings[K][], id: string, label: string, more?: More): Command => {
    const { settings } = this.app;
    const next = (): Settings[K] => values[(values.indexOf(settings.value[key]) + 1) % values.length];
    return this.always(id, label, () => settings.set({ [key]: next() }), more);
  };

  /** A command that chooses a tool, or the plain pointer if the tool is already chosen. */
  readonly tool = (name: Settings['tool'], label: string, key: string): Command => {
    const { settings } = this.app;
    const checked = (): boolean => settings.value.tool === name;
    return this.always(`tool-${name}`, label, () => settings.set({ tool: checked() ? 'select' : name }), { keys: [key], icon: name, checked });
  };
}

function fileCommands(app: CommandTarget): Command[] {
  const { always, onScene, onEditable } = new Makers(app, 'File');
  const open = (accept: string) => () => chooseFiles(accept, (files) => app.opener.takeFiles(files));
  const showExport = ({ session, units }: SceneView): void =>
    showExportDialog({
      formats: EXPORT_FORMATS,
      view: app.settings.value.view,
      last: app.settings.value,
      diagonal: session.surface.bounds.min.distanceTo(session.surface.bounds.max),
      units,
      patches: session.surface.patchCount,
      chosen: (choice) => app.settings.set(choice),
      saved: ({ name, certifiedError }) => {
        if (certifiedError === 0) return;
        app.toasts.tell(`${name} is within ${lengthsInWords([certifiedError], units, 2)} of the exact surface, at any point.`);
      },
      write: (...order) => downloadExport(app.services.server, session.sceneId, ...order),
    });
  return [
    always('open', 'Open mesh…', open(MESH_ENDINGS), { keys: ['Ctrl+O'], icon: 'open' }),
    ...(Object.keys(SAMPLES) as SampleName[]).map((name) =>
      always(`sample-${name}`, `Sample: ${name}`, () => app.opener.takeSample(name), { icon: 'sample' })),
    onEditable('open-lattice', 'Open lattice…', open('.json'), { icon: 'load' }),
    onScene('save-lattice', 'Save lattice', () => app.opener.saveLattice(), { keys: ['Ctrl+S'], icon: 'save' }),
    onScene('export', 'Export…', showExport, { keys: ['Ctrl+E'], icon: 'export' }),
    onScene('share', 'Share…', ({ session }) => share(app, session.sceneId), {
      icon: 'share', enabled: () => app.scene?.session.mayShare === true,
    }),
    onScene('copy-link', 'Copy link to this scene', () => void copyLink(app)),
  ];
}

/** The address without its fragment, which may hold this person's token. */
function plainLink(): string {
  return location.origin + location.pathname + location.search;
}

/** What others do not get with a link. */
function unshared(app: CommandTarget): string {
  const { companionsStay } = app.opener;
  return companionsStay ? ` Files dropped with the mesh stay ${companionsStay}.` : '';
}

async function copied(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false; // no clipboard without https
  }
}

async function copyLink(app: CommandTarget): Promise<void> {
  const link = plainLink();
  const told = `The link is copied. Everyone with access to this server edits the same scene by it.${unshared(app)}`;
  app.toasts.tell((await copied(link)) ? told : `Copy this link: ${link}`);
}

function share(app: CommandTarget, sceneId: string): void {
  showShareDialog({
    shares: new SceneShares(app.services.server, sceneId),
    linkWith: (token) => `${plainLink()}#token=${token}`,
    copy: copied,
    remark: unshared(app),
  });
}

function editCommands(app: CommandTarget): Command[] {
  const { onEditable } = new Makers(app, 'Edit');
  return [
    onEditable('undo', 'Undo', ({ session }) => session.undo(), {
      keys: ['Ctrl+Z'], icon: 'undo', idle: () => app.scene?.session.canUndo === false,
    }),
    onEditable('redo', 'Redo', ({ session }) => session.redo(), {
      keys: ['Ctrl+Shift+Z', 'Ctrl+Y'], icon: 'redo', idle: () => app.scene?.session.canRedo === false,
    }),
    onEditable('reset', 'Reset to rest', ({ session }) => session.reset('identity'), { icon: 'reset' }),
    onEditable('reset-initial', 'Reset to the first lattice', ({ session }) => session.reset('initial')),
    onEditable('carry', 'Carry by a parent lattice…', (scene) => scene.carryPoints()),
    onEditable('resize', 'Size and degree…', (scene) => scene.resizeLattice()),
    onEditable('outside', 'Outside the lattice…', (scene) => scene.chooseOutside()),
    onEditable('add-lattice', 'Add a lattice…', (scene) => scene.addLattice()),
    onEditable('remove-lattice', 'Remove this lattice', ({ session }) => session.removeLattice(), {
      idle: () => (app.scene?.session.latticeCount ?? 0) < 2,
    }),
    onEditable('knot', 'Insert knot plane…', (scene) => scene.placeKnot(), { keys: ['K'], icon: 'knot' }),
  ];
}

function selectCommands(app: CommandTarget): Command[] {
  const { onScene, onOff, tool } = new Makers(app, 'Select');
  const { settings } = app;
  const lines = AXIS_NAMES.flatMap((name, axis) => {
    const key = name.toUpperCase();
    return [
      onScene(`row-${name}`, `Row along ${name}`, ({ editor }) => editor.selectRows(axis as Axis, false), { keys: [key] }),
      onScene(`plane-${name}`, `Plane across ${name}`, ({ editor }) => editor.selectRows(axis as Axis, true), { keys: [`Shift+${key}`] }),
    ];
  });
  return [
    onScene('select-all', 'All', ({ editor }) => editor.selection.all(), { keys: ['A'], icon: 'all' }),
    onScene('select-none', 'None', ({ editor }) => editor.selection.none(), { keys: ['Alt+A'], icon: 'none' }),
    onScene('select-invert', 'Invert', ({ editor }) => editor.selection.invert(), { keys: ['Ctrl+I'], icon: 'invert' }),
    ...lines,
    onScene('hide', 'Hide selected', ({ editor: { selection } }) => selection.hide(selection.indices), { keys: ['H'], icon: 'eyeOff' }),
    onScene('hide-inner', 'Hide inner points', ({ editor }) => editor.hideInner(), { keys: ['Shift+H'] }),
    onScene('reveal', 'Show hidden', ({ editor }) => editor.selection.reveal(), { keys: ['Alt+H'], icon: 'eye' }),
    onOff('toggling', 'Add and take out, one by one', { icon: 'extend' }),
    onOff('through', 'Through the surface', { keys: ['Alt+Z'], icon: 'through' }),
    tool('select', 'Select', 'Q'),
    tool('box', 'Select by a box', 'B'),
    onScene('leave-tool', 'Leave the tool', () => settings.set({ tool: 'select' }), { keys: ['Escape'] }),
  ];
}

function transformCommands(app: CommandTarget): Command[] {
  const { settings, toasts } = app;
  const { always, onScene, onEditable, cycle, tool } = new Makers(app, 'Transform');
  const kinds = [['move', 'Move', 'G'], ['rotate', 'Rotate', 'R'], ['scale', 'Scale', 'S']] as const;
  const begin = kinds.map(([kind, label, key]) => onEditable(kind, label, (scene) => {
    if (!scene.beginTransform(kind)) toasts.tell('Select control points first: click one, or A for all.');
  }, { keys: [key] }));
  const handles = kinds.map(([kind, label]) => {
    const checked = (): boolean => settings.value.gizmo === kind;
    const run = (): void => settings.set({ gizmo: checked() ? 'none' : kind, tool: 'select' });
    return always(`gizmo-${kind}`, `${label} handles`, run, { icon: kind, checked });
  });
  const mirrors = AXIS_NAMES.map((name, axis) => {
    const run = (): void => settings.set({ mirror: switchedMirror(settings.value.mirror, axis as Axis) });
    return always(`mirror-${name}`, `Mirror over ${name}`, run, { keys: [`Alt+${name.toUpperCase()}`], checked: () => settings.value.mirror[axis] });
  });
  const soft = (): Settings['soft'] => settings.value.soft;
  return [
    ...begin,
    tool('pull', 'Pull the surface', 'P'),
    tool('paint', 'Paint weights', 'W'),
    ...handles,
    cycle('orientation', ['world', 'lattice', 'view'], 'cycle-orientation', 'Next axes', { keys: [','] }),
    cycle('pivot', ['median', 'active', 'each'], 'cycle-pivot', 'Next pivot', { keys: ['.'] }),
    always('soft', 'Soft selection', () => settings.set({ soft: { ...soft(), enabled: !soft().enabled } }), {
      keys: ['O'], icon: 'soft', checked: () => soft().enabled,
    }),
    onScene('soft-smaller', 'Smaller soft radius', ({ editor }) => editor.resizeSoft(-1), { keys: ['[', 'PageDown'] }),
    onScene('soft-larger', 'Larger soft radius', ({ editor }) => editor.resizeSoft(1), { keys: [']', 'PageUp'] }),
    ...mirrors,
  ];
}

function viewCommands(app: CommandTarget): Command[] {
  const { always, onScene, onOff, cycle } = new Makers(app, 'View');
  const look = (id: string, label: string, from: Vec3, key: string, icon?: IconName): Command =>
    always(id, label, () => app.viewport.rig.lookFromSide(from), { keys: [key], icon });
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
    cycle('compare', ['off', 'split', 'over'], 'compare', 'Compare with vertices only', {
      keys: ['D'], icon: 'compare', checked: () => app.settings.value.compare !== 'off', enabled: () => app.scene !== undefined,
    }),
    onOff('knotBoxes', 'Box edges', { keys: ['J'] }),
    onOff('cage', 'Cage', { keys: ['C'], icon: 'lattice' }),
    onOff('shadow', 'Ground shadow'),
    onOff('panel', 'Side panel', { keys: ['N'], icon: 'panel', enabled: () => app.scene !== undefined }),
    cycle('light', LIGHTS, 'light', 'Next light'),
    cycle('theme', ['system', 'dark', 'light'], 'theme', 'Theme: system, dark, light', { icon: 'theme' }),
    onScene('you', 'Your name and colour…', () => app.people.introduce()),
    always('help', 'Keys', () => showHelp(app.commands.list), { keys: ['?'], icon: 'help' }),
  ];
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { MESH_ENDINGS } from '../intake/mesh_file';
import { EXPORT_FORMATS } from '../intake/services';
import type { SceneView } from '../scene_view';
import type { Command } from '../ui/commands';
import { showExportDialog } from '../ui/dialogs/export_dialog';
import { chooseFiles } from '../ui/dialogs/start_screen';
import { downloadExport } from '../wire/export_download';
import { makersOf, type CommandTarget } from './command_makers';

export function fileCommands(app: CommandTarget): Command[] {
  const { onScene } = makersOf(app, 'File');
  const open = (accept: string) => () => chooseFiles(accept, (files) => app.opener.takeFiles(files));
  const showExport = ({ session }: SceneView): void =>
    showExportDialog({
      formats: EXPORT_FORMATS,
      view: app.settings.value.view,
      patches: session.surface.patchCount,
      write: (...order) => downloadExport(app.services.server, session.sceneId, ...order),
    });
  return [
    { id: 'open', label: 'Open mesh…', group: 'File', keys: ['Ctrl+O'], icon: 'open', run: open(MESH_ENDINGS) },
    ...(['knot', 'vase', 'slab'] as const).map((name): Command => {
      const run = (): void => app.opener.takeSample(name);
      return { id: `sample-${name}`, label: `Sample: ${name}`, group: 'File', icon: 'sample', run };
    }),
    onScene('open-lattice', 'Open lattice…', open('.json'), { icon: 'load' }),
    onScene('save-lattice', 'Save lattice', () => app.opener.saveLattice(), { keys: ['Ctrl+S'], icon: 'save' }),
    onScene('export', 'Export…', showExport, { keys: ['Ctrl+E'], icon: 'export' }),
    onScene('share', 'Copy link to this scene', () => void copyLink(app), { icon: 'share' }),
  ];
}

/** Without the address's fragment, which may hold this person's token. */
async function copyLink(app: CommandTarget): Promise<void> {
  const link = location.origin + location.pathname + location.search;
  try {
    await navigator.clipboard.writeText(link);
    const { companionsStay } = app.opener;
    const unshared = companionsStay ? ` What was dropped beside the mesh stays ${companionsStay}.` : '';
    app.toasts.tell(`The link is copied. Who opens it edits the same scene.${unshared}`);
  } catch {
    app.toasts.tell(`Copy this link: ${link}`); // no clipboard without https
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { MESH_ENDINGS } from '../intake/mesh_file';
import { EXPORT_FORMATS } from '../intake/services';
import type { Command } from '../ui/commands';
import { showExportDialog } from '../ui/export_dialog';
import { chooseFiles } from '../ui/start_screen';
import { onScene, type CommandTarget } from './command_makers';

export function fileCommands(app: CommandTarget): Command[] {
  const open = (accept: string) => () => chooseFiles(accept, (files) => app.opener.takeFiles(files));
  return [
    { id: 'open', label: 'Open mesh…', group: 'File', keys: ['Ctrl+O'], icon: 'open', run: open(MESH_ENDINGS) },
    ...(['knot', 'vase', 'slab'] as const).map((name): Command => ({
      id: `sample-${name}`,
      label: `Sample: ${name}`,
      group: 'File',
      icon: 'sample',
      run: () => app.opener.takeSample(name),
    })),
    onScene(app, 'File', 'open-lattice', 'Open lattice…', open('.json'), { icon: 'load' }),
    onScene(app, 'File', 'save-lattice', 'Save lattice', () => app.opener.saveLattice(), {
      keys: ['Ctrl+S'],
      icon: 'save',
    }),
    onScene(
      app,
      'File',
      'export',
      'Export…',
      ({ session }) =>
        showExportDialog({
          formats: EXPORT_FORMATS,
          view: app.settings.value.view,
          patches: session.surface.patchCount,
          write: (...order) => app.services.exportScene(session.sceneId, ...order),
        }),
      {
        keys: ['Ctrl+E'],
        icon: 'export',
      },
    ),
    onScene(app, 'File', 'share', 'Copy link to this scene', () => void copyLink(app), { icon: 'share' }),
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

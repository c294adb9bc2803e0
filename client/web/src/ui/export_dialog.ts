// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ExportFormat } from '../intake/services';
import { button } from './controls';
import { h, showDialog } from './dom';

const NOTES: Record<ExportFormat, string> = {
  glb: 'glTF binary: for most viewers and engines',
  ply: 'Binary PLY, with normals and texture coordinates',
  obj: 'Wavefront OBJ, with groups as materials',
  stl: 'Binary STL: positions alone',
  drc: 'Draco: the smallest',
};

/** Links to the deformed surface as a file; the server writes it when it is asked for. */
export function showExportDialog(formats: readonly ExportFormat[], address: (format: ExportFormat) => string): void {
  const links = formats.map((format) =>
    h(
      'a',
      { class: 'export-link', href: address(format), download: '', onclick: () => setTimeout(() => dialog.close()) },
      h('b', {}, format.toUpperCase()),
      h('small', {}, NOTES[format]),
    ),
  );
  const dialog = showDialog(
    'Export',
    'export',
    h('h2', {}, 'Export the deformed surface'),
    ...links,
    h(
      'footer',
      {},
      button('Cancel', () => dialog.close()),
    ),
  );
}

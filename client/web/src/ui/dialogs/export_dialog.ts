// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ExportFormat } from '../../intake/services';
import type { ExportedFile, ExportGeometry, ExportView } from '../../wire/export_download';
import { bytes, inWords } from '../../wire/words';
import { button, field, segmented } from '../controls';
import { h, onEnter, showDialog } from '../dom';
import { numberField } from '../fields/number_field';
import { saveFile } from '../save_file';

const NOTES: Record<ExportFormat, string> = {
  glb: 'glTF binary: for most viewers and engines, with the materials of an uploaded GLB',
  ply: 'Binary PLY, with texture coordinates where the mesh has them',
  obj: 'Wavefront OBJ, with groups as materials',
  usda: 'OpenUSD as text, with groups as materials',
  stl: 'Binary STL: positions alone',
  drc: 'Draco: the smallest',
  nets: 'Bézier patches in double precision, exact whatever the segments',
};

export type Export = (
  format: ExportFormat,
  view: ExportView,
  progress: (received: number, all: number) => void,
  signal: AbortSignal,
) => Promise<ExportedFile>;

export interface ExportDialogParts {
  readonly formats: readonly ExportFormat[];
  /** The view of the page, with which the dialog begins. */
  readonly view: ExportView;
  readonly patches: number;
  /** The format that Enter takes: the last one. */
  readonly last: ExportFormat;
  /** Remembers what was taken. */
  chosen(format: ExportFormat, geometry: ExportGeometry): void;
  readonly write: Export;
}

const NORMALS: Record<ExportView['normals'], string> = {
  smooth: 'smooth normals',
  facet: 'normals of facets',
  none: 'no normals',
};

const MOST_SEGMENTS = 32;

/** Asks for segments and a format. When a format is chosen, the server writes the deformed surface in it. */
export function showExportDialog({ formats, view, patches, last, chosen, write }: ExportDialogParts): void {
  let { segments, geometry } = view;
  const facts = h('p', { class: 'facts', role: 'status' });
  const amount = numberField(
    { label: 'Segments', get: () => segments, set: (n) => (segments = n) },
    { min: 1, max: MOST_SEGMENTS, whole: true, live: true },
  );
  const setGeometry = (chosenOne: ExportGeometry): void => {
    geometry = chosenOne;
    what.refresh();
    showFacts();
  };
  const what = segmented<ExportGeometry>(
    { label: 'Shape', get: () => geometry, set: setGeometry }, { exact: 'Exact surface', original: 'Original mesh' });
  const factsOf = (): string => {
    if (geometry === 'original') return `The vertices and faces of the file, moved; ${view.normals === 'smooth' ? 'smooth normals' : 'no normals'}`;
    if (!amount.isValid()) return `Segments are 1 to ${MOST_SEGMENTS}.`;
    return `${(patches * segments ** 2).toLocaleString('en')} triangles, ${NORMALS[view.normals]}`;
  };
  const isOffered = (format: ExportFormat): boolean =>
    geometry === 'exact' ? amount.isValid() : format !== 'nets'; // nets are patches of the exact surface
  const showFacts = (): void => {
    facts.textContent = factsOf();
    amount.input.disabled = geometry === 'original';
    choices.forEach((choice, i) => (choice.disabled = !isOffered(formats[i])));
  };
  for (const event of ['input', 'change', 'keydown']) amount.element.addEventListener(event, showFacts);
  const abort = new AbortController();
  const note = h('p', { class: 'note', role: 'status' });
  const error = h('p', { class: 'error', role: 'alert' });
  const choices = formats.map((format) =>
    h(
      'button',
      { type: 'button', class: 'export-choice', onclick: () => void save(format) },
      h('b', {}, format.toUpperCase()),
      h('small', {}, NOTES[format]),
      format === last && h('kbd', {}, 'Enter'),
    ),
  );
  const dialog = showDialog(
    'Export',
    'export',
    h('h2', {}, 'Export the deformed mesh'),
    what.element,
    field('Segments', amount.element),
    facts,
    ...choices,
    note,
    error,
    h('footer', {}, button('Cancel', () => dialog.close())),
  );
  dialog.addEventListener('close', () => abort.abort());
  onEnter(dialog, () => isOffered(last) && void save(last));
  what.refresh();
  showFacts();

  const save = async (format: ExportFormat): Promise<void> => {
    chosen(format, geometry);
    for (const control of [amount.input, ...choices]) control.disabled = true;
    error.textContent = '';
    note.textContent = `The server writes the ${format.toUpperCase()} …`;
    try {
      const { name, blob } = await write(format, { ...view, segments, geometry }, (received, all) => {
        note.textContent = `${bytes(received)} of ${bytes(all)}`;
      }, abort.signal);
      saveFile(name, blob);
      dialog.close();
    } catch (failure) {
      error.textContent = inWords(failure);
      note.textContent = '';
      showFacts();
    }
  };
}

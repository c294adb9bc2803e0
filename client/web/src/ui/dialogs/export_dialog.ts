// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ExportFormat } from '../../intake/services';
import type { Settings } from '../../state/settings';
import { lengthsInWords, type Units } from '../../state/units';
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

/** What is chosen; Enter takes the last format. */
type ExportChoice = Pick<Settings, 'exportFormat' | 'exportGeometry' | 'exportDetail' | 'exportTolerance'>;

export interface ExportDialogParts {
  readonly formats: readonly ExportFormat[];
  /** The view of the page, whose segments and normals the dialog begins with. */
  readonly view: Pick<ExportView, 'segments' | 'normals'>;
  readonly patches: number;
  /** Of the surface's bounds, in world units. */
  readonly diagonal: number;
  readonly units: Units;
  readonly last: ExportChoice;
  /** Remembers what was taken. */
  chosen(choice: ExportChoice): void;
  readonly write: Export;
  saved(file: ExportedFile): void;
}

const NORMALS: Record<ExportView['normals'], string> = {
  smooth: 'smooth normals',
  facet: 'normals of facets',
  none: 'no normals',
};

const MOST_SEGMENTS = 32;
const TRIANGLES_ALLOWED = 20_000_000; // of an export by tolerance; the server reserves memory for as many

/** The tolerance in world units, to three digits. */
function toleranceOf(part: number, diagonal: number): number {
  return Number((part * diagonal).toPrecision(3));
}

/** Asks for segments or a tolerance, and a format. When a format is chosen, the server writes the deformed surface in it. */
export function showExportDialog({ formats, view, patches, diagonal, units, last, chosen, write, saved }: ExportDialogParts): void {
  let { segments } = view;
  let { exportGeometry: geometry, exportDetail: detail } = last;
  const { exportFormat: lastFormat } = last;
  let tolerance = toleranceOf(last.exportTolerance, diagonal);
  const facts = h('p', { class: 'facts', role: 'status' });
  const amount = numberField(
    { label: 'Segments', get: () => segments, set: (n) => (segments = n) },
    { min: 1, max: MOST_SEGMENTS, whole: true, live: true },
  );
  const distance = numberField(
    { label: 'Tolerance', get: () => tolerance, set: (length) => (tolerance = length) },
    { min: toleranceOf(1e-9, diagonal), step: toleranceOf(1e-5, diagonal), live: true },
  );
  const what = segmented<ExportGeometry>({ label: 'Shape', get: () => geometry, set: (chosenOne) => {
    geometry = chosenOne;
    showFacts();
  } }, { exact: 'Exact surface', original: 'Original mesh' });
  const how = segmented<ExportChoice['exportDetail']>({ label: 'Detail', get: () => detail, set: (chosenOne) => {
    detail = chosenOne;
    showFacts();
  } }, { segments: 'By segments', tolerance: 'By tolerance' });
  const isValid = (): boolean => (detail === 'segments' ? amount : distance).isValid();
  const factsOf = (): string => {
    if (geometry === 'original') return `The vertices and faces of the file, moved; ${view.normals === 'smooth' ? 'smooth normals' : 'no normals'}`;
    if (detail === 'tolerance') {
      if (!isValid()) return 'The tolerance is a length.';
      const part = Number((tolerance / diagonal).toPrecision(2));
      return `Within ${lengthsInWords([tolerance], units, 2)} of the exact surface, ${part} of its diagonal; ${NORMALS[view.normals]}`;
    }
    if (!isValid()) return `Segments are 1 to ${MOST_SEGMENTS}.`;
    return `${(patches * segments ** 2).toLocaleString('en')} triangles, ${NORMALS[view.normals]}`;
  };
  const isOffered = (format: ExportFormat): boolean =>
    geometry === 'exact' ? isValid() : format !== 'nets'; // nets are patches of the exact surface
  const showFacts = (): void => {
    facts.textContent = factsOf();
    what.refresh();
    how.refresh();
    amountField.hidden = detail === 'tolerance';
    distanceField.hidden = detail === 'segments';
    for (const { input } of [amount, distance]) input.disabled = geometry === 'original';
    choices.forEach((choice, i) => (choice.disabled = !isOffered(formats[i])));
  };
  for (const event of ['input', 'change', 'keydown']) {
    for (const { element } of [amount, distance]) element.addEventListener(event, showFacts);
  }
  const abort = new AbortController();
  const note = h('p', { class: 'note', role: 'status' });
  const error = h('p', { class: 'error', role: 'alert' });
  const choices = formats.map((format) =>
    h(
      'button',
      { type: 'button', class: 'export-choice', onclick: () => void save(format) },
      h('b', {}, format.toUpperCase()),
      h('small', {}, NOTES[format]),
      format === lastFormat && h('kbd', {}, 'Enter'),
    ),
  );
  const [amountField, distanceField] = [field('Segments', amount.element), field('Tolerance', distance.element)];
  const dialog = showDialog(
    'Export',
    'export',
    h('h2', {}, 'Export the deformed mesh'),
    what.element,
    how.element,
    amountField,
    distanceField,
    facts,
    ...choices,
    note,
    error,
    h('footer', {}, button('Cancel', () => dialog.close())),
  );
  dialog.addEventListener('close', () => abort.abort());
  onEnter(dialog, () => isOffered(lastFormat) && void save(lastFormat));
  showFacts();

  const wanted = (): ExportView => {
    const { normals } = view;
    if (detail === 'segments' || geometry === 'original') return { segments, tolerance: 0, normals, geometry };
    const allowed = Math.floor(Math.sqrt(TRIANGLES_ALLOWED / Math.max(patches, 1)));
    return { segments: Math.min(Math.max(allowed, 1), MOST_SEGMENTS), tolerance, normals, geometry };
  };

  const save = async (format: ExportFormat): Promise<void> => {
    chosen({ exportFormat: format, exportGeometry: geometry, exportDetail: detail, exportTolerance: tolerance / diagonal });
    for (const control of [amount.input, distance.input, ...choices]) control.disabled = true;
    error.textContent = '';
    note.textContent = `The server writes the ${format.toUpperCase()} …`;
    try {
      const file = await write(format, wanted(), (received, all) => {
        note.textContent = `${bytes(received)} of ${bytes(all)}`;
      }, abort.signal);
      saveFile(file.name, file.blob);
      dialog.close();
      saved(file);
    } catch (failure) {
      error.textContent = inWords(failure);
      note.textContent = '';
      showFacts();
    }
  };
}

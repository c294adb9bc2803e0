// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks for the lattice of a dropped mesh. The upload of the mesh begins at once.
import type { Mesh } from 'latticed/v1/mesh_pb';
import type { MeshFile } from '../../intake/mesh_file';
import { fitLattice } from '../../lattice/fitted_lattice';
import { AXES } from '../../lattice/grid';
import { DEFAULT_FIT, type Fit } from '../../lattice/identity';
import type { UpAxis } from '../../state/units';
import type { RestCorners } from '../../surface/patch_source';
import { vector } from '../../wire/lattice_message';
import { bytes, inWords } from '../../wire/words';
import { button, field, segmented, toggle } from '../controls';
import { h, onEnter, showDialog } from '../dom';
import { axesTable } from '../fields/axes_table';
import { numberField } from '../fields/number_field';
import { OutsideForm, type OutsideChoice } from '../fields/outside_form';
import { FitPreview } from './fit_preview';

const DEFAULT_CREASE_ANGLE = 30; // the server's
const NOTES: Record<OutsideChoice, string> = { // the frame holds all of the mesh
  fixed: 'The whole mesh is inside. Point sets and other lattices outside stay.',
  falloff: 'The whole mesh is inside. For point sets and other lattices outside, the move fades out.',
  linear: 'The whole mesh is inside. Point sets and other lattices outside go on along straight lines, up to the width.',
};
const MOST_FACES = 30_000; // of a previewed mesh; drawing them takes about a tenth of a second

interface FitDialogParts {
  readonly file: MeshFile;
  upload(progress: (fraction: number) => void, signal: AbortSignal): Promise<Mesh>;
  /** The mesh's triangles, for a preview. */
  triangles(mesh: string): Promise<RestCorners>;
  /** The axis that is up; undefined: the file's format says it. */
  readonly up: UpAxis | undefined;
  create(mesh: Mesh, fit: Fit, options: FitOptions): Promise<void>;
}

interface FitOptions {
  readonly up: UpAxis | undefined;
  /** Degrees; undefined: nobody has changed it. */
  readonly creaseAngle: number | undefined;
  /** Whether vertices have the weights of the file. */
  readonly weighted: boolean;
}

/** Returns a function that closes the dialog. Closing also aborts the upload. */
export function showFitDialog({ file, upload, triangles, up: firstUp, create }: FitDialogParts): () => void {
  const fit: { -readonly [K in keyof Fit]: Fit[K] } = { ...DEFAULT_FIT };
  const abort = new AbortController();
  const preview = new FitPreview();
  preview.element.hidden = true;
  const bar = h('progress', { max: 1, value: 0, 'aria-label': 'Upload' });
  const facts = h('p', { class: 'facts' }, `${file.name}, ${bytes(file.content.size)}`);
  const status = h('p', { class: 'note', role: 'status' });
  const error = h('p', { class: 'error', role: 'alert' });
  let mesh: Mesh | undefined;
  let isUsed = false;
  let isConfirmed = false;
  let hasSize = true;
  let areNumbers = true;
  let up = firstUp;
  let creaseAngle: number | undefined;
  let takesWeights = true;

  const check = (): void => {
    confirm.disabled = mesh === undefined || !hasSize || !areNumbers;
    showPreview();
  };
  const showPreview = (): void => {
    if (mesh === undefined || !hasSize) return;
    preview.element.hidden = false;
    const bounds = { min: vector(mesh.bounds?.min), max: vector(mesh.bounds?.max) };
    preview.show(fitLattice(bounds, fit), up ?? 'y'); // glTF's is y
  };
  const submit = async (): Promise<void> => {
    if (mesh === undefined) return remember();
    if (confirm.disabled) return;
    confirm.disabled = true;
    error.textContent = '';
    const waiting = h('progress', { 'aria-label': 'Making the scene' }); // how long is not known
    facts.after(waiting);
    try {
      await create(mesh, fit, { up, creaseAngle, weighted: mesh.hasWeights && takesWeights });
      dialog.close();
    } catch (failure) {
      error.textContent = inWords(failure);
      confirm.disabled = false;
      waiting.remove();
    }
  };
  /** Enter during the upload counts once the mesh is there. */
  const remember = (): void => {
    if (bar.hidden) return; // the upload has failed
    isConfirmed = true;
    status.textContent = 'The scene is made as soon as the mesh is there. Esc cancels.';
  };
  const confirm = button('Create scene', () => void submit(), { class: 'button primary', disabled: true });

  const table = axesTable(fit, (isValid) => {
    hasSize = isValid;
    check();
  });
  const chooseUp = (axis: UpAxis): void => {
    up = axis;
    upSwitch.refresh();
    showPreview();
  };
  const upSwitch = segmented<'y' | 'z'>({ label: 'Up', get: () => (up === 'z' ? 'z' : 'y'), set: chooseUp }, { y: 'Y', z: 'Z' });
  const outside = new OutsideForm({
    first: undefined, width: 0.3, linearHasWidths: true, notes: NOTES,
    changed: () => {
      fit.outside = outside.wanted;
      typed();
    },
  });
  const setPadding = (percent: number): void => void (fit.padding = percent / 100);
  const typed = (): void => {
    areNumbers = padding.isValid() && crease.isValid() && outside.isValid;
    check();
  };
  const padding = numberField(
    { label: 'Padding', get: () => fit.padding * 100, set: setPadding }, { min: 0, max: 1000, live: true, typed });
  const setCrease = (degrees: number): void => void (creaseAngle = degrees);
  const crease = numberField(
    { label: 'Crease angle', get: () => creaseAngle ?? DEFAULT_CREASE_ANGLE, set: setCrease }, {
      min: 0, max: 180, live: true,
      typed: () => {
        if (crease.isValid()) creaseAngle ??= DEFAULT_CREASE_ANGLE; // chosen, though it is what was shown
        typed();
      },
    });
  const weights = toggle(
    { label: 'Weights of the file', get: () => takesWeights, set: (taken) => (takesWeights = taken) },
    'A vertex of weight 0 stays, one of weight 1 follows the lattice');
  weights.element.hidden = true;
  const dialog = showDialog(
    'Fit a lattice',
    'fit',
    h('h2', {}, 'Fit a lattice'),
    facts,
    bar,
    status,
    preview.element,
    table.element,
    field('Padding', padding.element, '% of the longest edge'),
    field('Sharp edges from', crease.element, '°'),
    up !== undefined && upSwitch.element,
    weights.element,
    table.note,
    outside.element,
    error,
    h('footer', {}, button('Cancel', () => dialog.close()), confirm),
  );
  dialog.addEventListener('close', () => abort.abort());
  for (const kind of ['pointerdown', 'keydown', 'input']) dialog.addEventListener(kind, () => (isUsed = true), { once: true });
  onEnter(dialog, () => void submit());

  const goUp = async (): Promise<void> => {
    mesh = await upload((fraction) => (bar.value = fraction), abort.signal);
    const [min, max] = [vector(mesh.bounds?.min), vector(mesh.bounds?.max)];
    const extent = AXES.map((axis) => Number((max[axis] - min[axis]).toPrecision(3))).join(' × ');
    const [vertices, faces] = [mesh.vertices, mesh.faces].map((count) => count.toLocaleString('en'));
    facts.textContent = `${mesh.name}: ${vertices} vertices, ${faces} faces, ${extent}`;
    crease.input.title = mesh.hasNormals ? 'The file has its own normals. A number here replaces them.' : '';
    weights.element.hidden = !mesh.hasWeights;
    check();
    status.textContent = '';
    if (isConfirmed) void submit();
    else if (!isUsed) confirm.focus(); // a person who uses a field stays there
    if (mesh.faces <= MOST_FACES) void showMesh(mesh.id).catch(() => undefined); // the lattice is shown without it
  };
  const showMesh = async (id: string): Promise<void> => {
    const shown = await triangles(id);
    if (!dialog.open) return;
    preview.setMesh(shown);
    showPreview();
  };
  goUp().catch((failure: unknown) => {
    status.textContent = '';
    if (!abort.signal.aborted) error.textContent = inWords(failure);
  }).finally(() => (bar.hidden = true));
  return () => dialog.close();
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks for the lattice of a dropped mesh. The upload of the mesh begins at once.
import type { Mesh } from 'latticed/v1/mesh_pb';
import type { MeshFile } from '../../intake/mesh_file';
import { AXES, AXIS_NAMES, pointCount, refusalOfAxes, type Axes, type Axis } from '../../lattice/grid';
import { DEFAULT_FIT, type Fit } from '../../lattice/identity';
import type { UpAxis } from '../../state/units';
import { vector } from '../../wire/lattice_message';
import { bytes, inWords } from '../../wire/words';
import { button, choice, field, segmented } from '../controls';
import { h, onEnter, showDialog } from '../dom';
import { numberField } from '../fields/number_field';

const DEGREES = { 1: '1, straight', 2: '2, smooth', 3: '3, smoother' };

interface FitDialogParts {
  readonly file: MeshFile;
  upload(progress: (fraction: number) => void, signal: AbortSignal): Promise<Mesh>;
  /** The axis that is up; undefined: the file's format says it. */
  readonly up: UpAxis | undefined;
  create(mesh: Mesh, fit: Fit, up: UpAxis | undefined): Promise<void>;
}

/** Returns a function that closes the dialog. Closing also aborts the upload. */
export function showFitDialog({ file, upload, up: firstUp, create }: FitDialogParts): () => void {
  const fit: { -readonly [K in keyof Fit]: Fit[K] } = { ...DEFAULT_FIT };
  const abort = new AbortController();
  const bar = h('progress', { max: 1, value: 0, 'aria-label': 'Upload' });
  const facts = h('p', { class: 'facts' }, `${file.name}, ${bytes(file.content.size)}`);
  const note = h('p', { class: 'note', role: 'status' });
  const error = h('p', { class: 'error', role: 'alert' });
  let mesh: Mesh | undefined;
  let isUsed = false;
  let up = firstUp;

  const check = (): void => {
    const refusal = refusalOfAxes(fit.size, fit.degree);
    note.textContent = refusal ?? `${pointCount(fit.size).toLocaleString('en')} control points`;
    note.classList.toggle('error', refusal !== undefined);
    confirm.disabled = refusal !== undefined || mesh === undefined;
  };
  const change = (key: 'size' | 'degree', axis: Axis, value: number): void => {
    fit[key] = fit[key].map((n, i) => (i === axis ? value : n)) as unknown as Axes;
    check();
  };
  const submit = async (): Promise<void> => {
    if (mesh === undefined || confirm.disabled) return;
    confirm.disabled = true;
    error.textContent = '';
    const waiting = h('progress', { 'aria-label': 'Making the scene' }); // how long is not known
    facts.after(waiting);
    try {
      await create(mesh, fit, up);
      dialog.close();
    } catch (failure) {
      error.textContent = inWords(failure);
      confirm.disabled = false;
      waiting.remove();
    }
  };
  const confirm = button('Create scene', () => void submit(), { class: 'button primary', disabled: true });

  const rows = AXES.flatMap((axis) => {
    const name = AXIS_NAMES[axis];
    const setSize = (n: number): void => change('size', axis, n);
    const bound = { label: `Points along ${name}`, get: () => fit.size[axis], set: setSize };
    const size = numberField(bound, { min: 2, max: 64, whole: true, live: true });
    const setDegree = (n: string): void => change('degree', axis, Number(n));
    const degree = choice<string>({ label: `Degree along ${name}`, get: () => String(fit.degree[axis]), set: setDegree }, DEGREES);
    return [h('b', { class: `axis-${name}` }, name), size.element, degree.element.querySelector('select')!];
  });
  const chooseUp = (axis: UpAxis): void => {
    up = axis;
    upSwitch.refresh();
  };
  const upSwitch = segmented<'y' | 'z'>({ label: 'Up', get: () => (up === 'z' ? 'z' : 'y'), set: chooseUp }, { y: 'Y', z: 'Z' });
  const table = { class: 'axes', role: 'group', 'aria-label': 'Lattice' };
  const setPadding = (percent: number): void => void (fit.padding = percent / 100);
  const padding = numberField({ label: 'Padding', get: () => fit.padding * 100, set: setPadding }, { min: 0, max: 1000, live: true });
  const dialog = showDialog(
    'Fit a lattice',
    'fit',
    h('h2', {}, 'Fit a lattice'),
    facts,
    bar,
    h('div', table, h('span', {}), h('span', {}, 'Points'), h('span', {}, 'Degree'), ...rows),
    field('Padding', padding.element, '% of the longest edge'),
    up !== undefined && upSwitch.element,
    note,
    error,
    h('footer', {}, button('Cancel', () => dialog.close()), confirm),
  );
  dialog.addEventListener('close', () => abort.abort());
  for (const kind of ['pointerdown', 'keydown', 'input']) dialog.addEventListener(kind, () => (isUsed = true), { once: true });
  onEnter(dialog, () => void submit());
  check();

  const goUp = async (): Promise<void> => {
    mesh = await upload((fraction) => (bar.value = fraction), abort.signal);
    const [min, max] = [vector(mesh.bounds?.min), vector(mesh.bounds?.max)];
    const extent = AXES.map((axis) => Number((max[axis] - min[axis]).toPrecision(3))).join(' × ');
    const [vertices, faces] = [mesh.vertices, mesh.faces].map((count) => count.toLocaleString('en'));
    facts.textContent = `${mesh.name}: ${vertices} vertices, ${faces} faces, ${extent}`;
    check();
    if (!isUsed) confirm.focus(); // a person who uses a field stays there
  };
  goUp().catch((failure: unknown) => {
    if (!abort.signal.aborted) error.textContent = inWords(failure);
  }).finally(() => (bar.hidden = true));
  return () => dialog.close();
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks for the lattice of a mesh that was dropped, while the mesh goes up: the upload begins at once.
import type { Mesh } from 'latticed/v1/mesh_pb';
import type { MeshFile } from '../../intake/mesh_file';
import { AXES, AXIS_NAMES, pointCount, refusalOfAxes, type Axes } from '../../lattice/grid';
import { DEFAULT_FIT, type Fit } from '../../lattice/identity';
import { vector } from '../../wire/lattice_message';
import { bytes, inWords } from '../../wire/words';
import { button, choice, numberInput, type Control } from '../controls';
import { h, onEnter, showDialog } from '../dom';

const DEGREES = { 1: '1, straight', 2: '2, smooth', 3: '3, smoother' };

export interface FitDialogParts {
  readonly file: MeshFile;
  upload(progress: (fraction: number) => void, signal: AbortSignal): Promise<Mesh>;
  create(mesh: Mesh, fit: Fit): Promise<void>;
}

export class FitDialog {
  private fit: Fit = { ...DEFAULT_FIT };
  private readonly abort = new AbortController();
  private readonly bar = h('progress', { max: 1, value: 0, 'aria-label': 'Upload' });
  private readonly facts = h('p', { class: 'facts' });
  private readonly note = h('p', { class: 'note', role: 'status' });
  private readonly error = h('p', { class: 'error', role: 'alert' });
  private readonly create = button('Create scene', () => void this.submit(), {
    class: 'button primary',
    disabled: true,
  });
  private readonly dialog: HTMLDialogElement;
  private mesh: Mesh | undefined;
  private isUsed = false;

  constructor(private readonly parts: FitDialogParts) {
    const { file } = parts;
    this.facts.textContent = `${file.name}, ${bytes(file.content.size)}`;
    this.dialog = showDialog(
      'Fit a lattice',
      'fit',
      h('h2', {}, 'Fit a lattice'),
      this.facts,
      this.bar,
      this.axesTable(),
      this.paddingField(),
      this.note,
      this.error,
      h('footer', {}, button('Cancel', () => this.dialog.close()), this.create),
    );
    this.dialog.addEventListener('close', () => this.abort.abort());
    for (const kind of ['pointerdown', 'keydown', 'input']) {
      this.dialog.addEventListener(kind, () => (this.isUsed = true), { once: true });
    }
    onEnter(this.dialog, () => void this.submit());
    this.check();
    void this.upload();
  }

  /** Gives up the upload with it. */
  close(): void {
    this.dialog.close();
  }

  private async upload(): Promise<void> {
    try {
      this.mesh = await this.parts.upload((fraction) => (this.bar.value = fraction), this.abort.signal);
    } catch (error) {
      if (!this.abort.signal.aborted) this.error.textContent = inWords(error);
      this.bar.hidden = true;
      return;
    }
    const { name, vertices, faces, bounds } = this.mesh;
    const [min, max] = [vector(bounds?.min), vector(bounds?.max)];
    const extent = AXES.map((axis) => Number((max[axis] - min[axis]).toPrecision(3))).join(' × ');
    this.facts.textContent = `${name}: ${vertices.toLocaleString('en')} vertices, ${faces.toLocaleString('en')} faces, ${extent}`;
    this.bar.hidden = true;
    this.check();
    if (!this.isUsed) this.create.focus(); // whoever is at a field goes on there
  }

  private async submit(): Promise<void> {
    if (this.mesh === undefined || this.create.disabled) return;
    this.create.disabled = true;
    this.error.textContent = '';
    try {
      await this.parts.create(this.mesh, this.fit);
      this.dialog.close();
    } catch (error) {
      this.error.textContent = inWords(error);
      this.create.disabled = false;
    }
  }

  private axesTable(): HTMLElement {
    const table = h(
      'div',
      { class: 'axes', role: 'group', 'aria-label': 'Lattice' },
      h('span', {}),
      h('span', {}, 'Points'),
      h('span', {}, 'Degree'),
    );
    for (const axis of AXES) {
      const name = AXIS_NAMES[axis];
      const size = numberInput(
        {
          label: `Points along ${name}`,
          get: () => this.fit.size[axis],
          set: (n) => this.change({ size: replaced(this.fit.size, axis, n) }),
        },
        { min: 2, max: 64, step: 1 },
      );
      const degree: Control = choice<string>(
        {
          label: `Degree along ${name}`,
          get: () => String(this.fit.degree[axis]),
          set: (d) => this.change({ degree: replaced(this.fit.degree, axis, Number(d)) }),
        },
        DEGREES,
      );
      size.refresh();
      degree.refresh();
      table.append(h('b', { class: `axis-${name}` }, name), size.element, degree.element.querySelector('select')!);
    }
    return table;
  }

  private paddingField(): HTMLElement {
    const padding = numberInput(
      {
        label: 'Padding',
        get: () => this.fit.padding * 100,
        set: (percent) => this.change({ padding: percent / 100 }),
      },
      { min: 0, max: 1000 },
    );
    padding.refresh();
    return h(
      'label',
      { class: 'field' },
      h('span', { class: 'field-label' }, 'Padding'),
      h('span', { class: 'field-content' }, padding.element, '% of the longest edge'),
    );
  }

  private change(change: Partial<Fit>): void {
    this.fit = { ...this.fit, ...change };
    this.check();
  }

  private check(): void {
    const refusal = refusalOfAxes(this.fit.size, this.fit.degree);
    this.note.textContent = refusal ?? `${pointCount(this.fit.size).toLocaleString('en')} control points`;
    this.note.classList.toggle('error', refusal !== undefined);
    this.create.disabled = refusal !== undefined || this.mesh === undefined;
  }
}

function replaced(axes: Axes, axis: 0 | 1 | 2, value: number): Axes {
  const copy = [...axes] as [number, number, number];
  copy[axis] = value;
  return copy;
}

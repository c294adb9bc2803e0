// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the scene's edits keep: the enclosed volume, held control points and layers, a mirror. It is the scene's, so all
// who edit it share it; a change is an edit with undo.
import type { Editor } from '../edit/editor';
import { withLayers, type Constraints } from '../lattice/constraints';
import { AXIS_NAMES, type Axis } from '../lattice/grid';
import { field, segmented, toggle, type Control } from './controls';
import { h } from './dom';

type LayerChoice = '0' | '1' | '2' | '3' | 'some';

export class ConstraintControls implements Control {
  readonly element = h('div', { class: 'constraints' });
  private readonly controls: Control[];
  private readonly volume = h('p', { class: 'facts', role: 'status' });
  private readonly held = h('p', { class: 'facts' });
  private readonly hold = h('button', { type: 'button', onclick: () => this.holdSelected() }, 'Hold selected');
  private readonly release = h('button', { type: 'button', onclick: () => this.set({ held: [] }) }, 'Release all');
  private editor: Editor | undefined;

  constructor() {
    const keepsVolume = toggle({
      label: 'Keep volume',
      get: () => this.now?.volume !== undefined,
      set: (on) => this.set({ volume: on ? {} : undefined }),
    }, 'Free control points move along');
    const layers = segmented<LayerChoice>({
      label: 'Held layers at all faces',
      get: () => this.layerChoice(),
      set: (count) => this.editor?.session.constrain(withLayers(this.now!, Number(count))),
    }, { 0: 'None', 1: '1', 2: '2', 3: '3' } as Record<LayerChoice, string>);
    const mirrors = AXIS_NAMES.map((name, axis) => toggle({
      label: name,
      get: () => this.now?.mirror === axis,
      set: (on) => this.set({ mirror: on ? (axis as Axis) : undefined }),
    }, `All edits are mirrored over ${name}`));
    this.controls = [keepsVolume, layers, ...mirrors];
    this.element.append(
      keepsVolume.element, this.volume, layers.element,
      field('Locked mirror', ...mirrors.map(({ element }) => element)),
      this.held, h('div', { class: 'buttons' }, this.hold, this.release),
    );
  }

  show(editor: Editor): void {
    this.editor = editor;
    this.showVolume('');
    this.refresh();
  }

  /** `text`: the volume with its unit, or why there is none. */
  showVolume(text: string): void {
    this.volume.textContent = text && `Volume ${text}`;
  }

  refresh(): void {
    for (const control of this.controls) control.refresh();
    const count = this.editor?.session.held.size ?? 0;
    this.held.textContent = `Held control points: ${count === 0 ? 'none' : count}`;
    const mayEdit = this.editor?.session.mayEdit ?? false;
    this.hold.disabled = !mayEdit || this.editor!.selection.size === 0;
    this.release.disabled = !mayEdit || (this.now?.held.length ?? 0) === 0;
    for (const input of this.element.querySelectorAll('input')) input.disabled = !mayEdit;
  }

  private get now(): Constraints | undefined {
    return this.editor?.session.constraints;
  }

  private set(change: Partial<Constraints>): void {
    if (this.editor) this.editor.session.constrain({ ...this.editor.session.constraints, ...change });
  }

  private holdSelected(): void {
    this.set({ held: [...new Set([...this.now!.held, ...this.editor!.selection.indices])] });
  }

  private layerChoice(): LayerChoice {
    const layers = this.now?.layers ?? [];
    if (layers.length === 0) return '0';
    const [first] = layers;
    const isAll = layers.length === 6 && layers.every((face) => face.layers === first!.layers);
    return isAll ? (String(first!.layers) as LayerChoice) : 'some';
  }
}

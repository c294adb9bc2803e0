// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The side panel: the selection, the behaviour of transforms, the surface's look and how it is sent.
import { FALLOFFS, type Falloff } from '../edit/falloff';
import type { Editor } from '../edit/editor';
import { switchedMirror } from '../edit/mirror';
import { AXIS_NAMES, type Axis } from '../lattice/grid';
import type { Vec3 } from '../lattice/vec';
import type { Settings, SettingsStore } from '../state/settings';
import { ConstraintControls } from './constraint_controls';
import { button, choice, field, segmented, slider, toggle, type Bound, type Control } from './controls';
import { h } from './dom';
import { LatticeChoice } from './lattice_choice';
import { StrengthControl } from './strength_control';
import { numberField } from './fields/number_field';

const [LEAST_PIXELS, MOST_PIXELS] = [0.1, 20];

type Key<T> = { [K in keyof Settings]: Settings[K] extends T ? K : never }[keyof Settings];

export class Panel {
  readonly element = h('aside', { class: 'panel', 'aria-label': 'Properties' });
  private readonly controls: Control[] = [];
  private readonly count = h('p', { class: 'facts' });
  private readonly radius: Control;
  private editor: Editor | undefined;
  readonly constraints = new ConstraintControls();
  private readonly strength = new StrengthControl();
  private readonly choice = new LatticeChoice();

  /** `giveBack` moves the focus from a field to the view. */
  constructor(private readonly settings: SettingsStore, private readonly giveBack: () => void) {
    this.radius = slider(this.partOf('soft', 'radius', 'Radius'), { min: 0, max: 1, step: 0.005 });
    this.element.append(
      this.section('Selection', this.count, this.positionFields(), this.switch('through', 'Through the surface', 'Alt+Z')),
      this.section('Transform', ...this.transformControls()),
      this.section('Soft selection', ...this.softControls()),
      this.section('Weights', ...this.brushControls()),
      this.section('Lattice', this.keep(this.choice), this.keep(this.strength)),
      this.section('Constraints', this.keep(this.constraints)),
      this.section('Surface', ...this.surfaceControls()),
      this.section('Stream', ...this.streamControls()),
    );
    settings.subscribe(() => this.refresh());
    this.refresh();
  }

  /** Shows another scene. `size` is its size in world units, the largest soft radius. */
  show(editor: Editor, size: number): void {
    this.editor = editor;
    this.constraints.show(editor);
    this.strength.show(editor.session);
    this.choice.show(editor.session);
    const range = this.radius.element.querySelector('input')!;
    range.max = String(size);
    range.step = String(size / 200);
    this.settings.set({ soft: { ...this.settings.value.soft, radius: size / 4 } });
    this.refresh();
  }

  refresh(): void {
    const selected = this.editor?.selection.size ?? 0;
    const hidden = this.editor?.selection.hiddenCount ?? 0;
    const all = this.editor?.lattice.count ?? 0;
    this.count.textContent = `${selected} of ${all} control points${hidden > 0 ? `, ${hidden} hidden` : ''}`;
    for (const control of this.controls) control.refresh();
  }

  private section(title: string, ...content: HTMLElement[]): HTMLElement {
    return h('details', { class: 'section', open: true }, h('summary', {}, title), ...content);
  }

  private keep(control: Control): HTMLElement {
    this.controls.push(control);
    return control.element;
  }

  /** Binds a whole setting. */
  private of<K extends keyof Settings>(key: K, label: string): Bound<Settings[K]> {
    return { label, get: () => this.settings.value[key], set: (value) => this.settings.set({ [key]: value }) };
  }

  /** Binds a part of a setting that is a record. */
  private partOf<K extends 'soft' | 'view' | 'brush', P extends keyof Settings[K]>(key: K, part: P, label: string): Bound<Settings[K][P]> {
    return {
      label,
      get: () => this.settings.value[key][part],
      set: (value) => this.settings.set({ [key]: { ...this.settings.value[key], [part]: value } }),
    };
  }

  private switch(key: Key<boolean>, label: string, hint?: string): HTMLElement {
    return this.keep(toggle(this.of(key, label), hint));
  }

  /** The pivot's coordinates, which a person can read and type. */
  private positionFields(): HTMLElement {
    const inputs = ([0, 1, 2] as const).map((axis) => {
      const get = (): number => (this.editor && this.editor.selection.size > 0 ? this.editor.pivot()[axis] : 0);
      const set = (value: number): void => {
        const place = [...this.editor!.pivot()] as [number, number, number];
        place[axis] = value;
        this.editor!.movePivotTo(place as Vec3);
      };
      const control = numberField({ label: `Pivot ${'XYZ'[axis]}`, get, set }, { step: 0.1, done: this.giveBack });
      const refresh = (): void => {
        control.input.disabled = (this.editor?.selection.size ?? 0) === 0 || !this.editor!.session.mayEdit;
        if (document.activeElement !== control.input) control.refresh();
      };
      return this.keep({ element: control.element, refresh });
    });
    return h('div', { class: 'position' }, h('span', { class: 'field-label' }, 'Position of the pivot'), ...inputs);
  }

  private pixelsField(): HTMLElement {
    const bound = this.of('pixels', 'Tolerance in pixels');
    const control = numberField(bound, { min: LEAST_PIXELS, max: MOST_PIXELS, step: LEAST_PIXELS, done: this.giveBack });
    const refresh = (): void => {
      control.input.disabled = this.settings.value.detail !== 'tolerance';
      if (document.activeElement !== control.input) control.refresh();
    };
    return field('Pixels', this.keep({ element: control.element, refresh }));
  }

  private transformControls(): HTMLElement[] {
    const handles = { none: 'None', move: 'Move', rotate: 'Rotate', scale: 'Scale' };
    return [
      this.keep(segmented(this.of('gizmo', 'Handles'), handles)),
      this.keep(segmented(this.of('orientation', 'Axes'), { world: 'World', lattice: 'Lattice', view: 'View' })),
      this.keep(segmented(this.of('pivot', 'Pivot'), { median: 'Median', active: 'Active', each: 'Each' })),
      this.switch('refuseFolds', 'Refuse folds'),
      field('Mirror', ...AXIS_NAMES.map((name, axis) => this.mirrorSwitch(name, axis as Axis))),
    ];
  }

  private mirrorSwitch(name: string, axis: Axis): HTMLElement {
    const get = (): boolean => this.settings.value.mirror[axis];
    const set = (): void => this.settings.set({ mirror: switchedMirror(this.settings.value.mirror, axis) });
    return this.keep(toggle({ label: name, get, set }, `Mirror over ${name}`));
  }

  private softControls(): HTMLElement[] {
    const falloffs = Object.fromEntries(Object.keys(FALLOFFS).map((name) => [name, name])) as Record<Falloff, string>;
    return [
      this.keep(toggle(this.partOf('soft', 'enabled', 'Nearby points follow'), 'O')),
      this.keep(this.radius),
      this.keep(choice(this.partOf('soft', 'falloff', 'Falloff'), falloffs)),
    ];
  }

  /** Of the tool that paints vertex weights. */
  private brushControls(): HTMLElement[] {
    const clear = button('Clear weights', () => this.editor?.session.clearWeights());
    return [
      this.keep(slider(this.partOf('brush', 'weight', 'Weight to paint'), { min: 0, max: 1, step: 0.05 })),
      this.keep(slider(this.partOf('brush', 'radius', 'Brush radius'), { min: 5, max: 200, step: 1 })),
      this.keep(slider(this.partOf('brush', 'strength', 'Brush strength'), { min: 0.05, max: 1, step: 0.05 })),
      h('div', { class: 'buttons' }, clear),
    ];
  }

  private surfaceControls(): HTMLElement[] {
    const colourings = {
      plain: 'Shaded', displacement: 'Displacement', difference: 'Vertices only to exact', boxes: 'Knot boxes', texture: 'Texture',
    };
    return [
      this.keep(choice(this.of('colouring', 'Colour'), colourings)),
      this.keep(choice(this.of('light', 'Light'), { studio: 'Studio', clay: 'Clay', jade: 'Jade', steel: 'Steel' })),
      this.keep(segmented(this.of('compare', 'Vertices only'), { off: 'Off', split: 'Split', over: 'Over' })),
      h(
        'div',
        { class: 'switches' },
        this.switch('surface', 'Surface'),
        this.switch('wireframe', 'Wireframe', 'Z'),
        this.switch('patchEdges', 'Patch edges'),
        this.switch('ghost', 'Rest shape'),
        this.switch('cage', 'Cage'),
        this.switch('knotBoxes', 'Box edges'),
        this.switch('shadow', 'Shadow'),
      ),
    ];
  }

  private streamControls(): HTMLElement[] {
    const isRaw = (): boolean => this.settings.value.view.encoding === 'raw';
    const hasNone = (): boolean => this.settings.value.view.normals === 'none';
    const steps = (bound: Bound<number>, min: number, max: number): HTMLElement =>
      this.keep(slider(bound, { min, max, step: 1 }, 'change'));
    const encodings = {
      patches: 'None: evaluated here', auto: 'Automatic', draco: 'Draco', meshopt: 'Meshopt', quantised: 'Quantised', raw: 'Raw floats',
    };
    return [
      this.keep(segmented(this.of('detail', 'Detail'), { tolerance: 'By tolerance', segments: 'By segments' })),
      this.pixelsField(),
      steps({ ...this.partOf('view', 'segments', 'Segments'), isIdle: () => this.settings.value.detail !== 'segments' }, 1, 32),
      this.keep(choice(this.partOf('view', 'normals', 'Normals'), { smooth: 'Smooth', facet: 'Facets', none: 'None' })),
      this.keep(choice(this.partOf('view', 'encoding', 'Encoding'), encodings)),
      steps({ ...this.partOf('view', 'positionBits', 'Position bits'), isIdle: isRaw }, 8, 16),
      steps({ ...this.partOf('view', 'normalBits', 'Normal bits'), isIdle: () => isRaw() || hasNone() }, 6, 12),
    ];
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The side panel: what is selected, how transforms behave, how the surface looks and how it is sent.
import { FALLOFFS, type Falloff } from '../edit/falloff';
import type { Editor } from '../edit/editor';
import { AXIS_NAMES, type Axis } from '../lattice/grid';
import type { Vec3 } from '../lattice/vec';
import type { ViewRequest } from '../session/scene_session';
import type { Settings, SettingsStore } from '../state/settings';
import { choice, field, numberInput, segmented, slider, toggle, type Control } from './controls';
import { h } from './dom';

type Key<T> = { [K in keyof Settings]: Settings[K] extends T ? K : never }[keyof Settings];

const LONGER: Partial<Record<string, string>> = { draco: 'Draco', quantised: 'Quantised', raw: 'Raw floats' };

export class Panel {
  readonly element = h('aside', { class: 'panel', 'aria-label': 'Properties' });
  private readonly controls: Control[] = [];
  private readonly count = h('p', { class: 'facts' });
  private readonly radius: Control;
  private editor: Editor | undefined;

  constructor(private readonly settings: SettingsStore) {
    this.radius = this.radiusSlider();
    this.element.append(
      this.section(
        'Selection',
        this.count,
        this.positionFields(),
        this.switch('through', 'Through the surface', 'Alt+Z'),
      ),
      this.section('Transform', ...this.transformControls()),
      this.section('Soft selection', ...this.softControls()),
      this.section('Surface', ...this.surfaceControls()),
      this.section('Stream', ...this.streamControls()),
    );
    settings.subscribe(() => this.refresh());
    this.refresh();
  }

  /** Shows another scene; `size` is its mesh's, for the slider of the soft radius. */
  show(editor: Editor, size: number): void {
    this.editor = editor;
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

  private switch(key: Key<boolean>, label: string, hint?: string): HTMLElement {
    return this.keep(
      toggle({ label, get: () => this.settings.value[key], set: (on) => this.settings.set({ [key]: on }) }, hint),
    );
  }

  private select<K extends Key<string>>(
    key: K,
    label: string,
    options: readonly (readonly [Settings[K] & string, string])[],
  ): HTMLElement {
    return this.keep(
      segmented(
        {
          label,
          get: () => this.settings.value[key] as Settings[K] & string,
          set: (value) => this.settings.set({ [key]: value }),
        },
        options,
      ),
    );
  }

  /** The pivot's coordinates, to be read and typed. */
  private positionFields(): HTMLElement {
    const inputs = ([0, 1, 2] as const).map((axis) => {
      const get = (): number => (this.editor && this.editor.selection.size > 0 ? this.editor.pivot()[axis] : 0);
      const set = (value: number): void => {
        const place = [...this.editor!.pivot()] as [number, number, number];
        place[axis] = value;
        this.editor!.movePivotTo(place as Vec3);
      };
      const control = numberInput({ label: `Pivot ${'XYZ'[axis]}`, get, set });
      const refresh = (): void => {
        control.element.disabled = (this.editor?.selection.size ?? 0) === 0;
        if (document.activeElement !== control.element) control.refresh();
      };
      return this.keep({ element: control.element, refresh });
    });
    return h('div', { class: 'position' }, h('span', { class: 'field-label' }, 'Position of the pivot'), ...inputs);
  }

  private transformControls(): HTMLElement[] {
    const mirrors = AXIS_NAMES.map((name, axis) => this.mirrorSwitch(name, axis as Axis));
    return [
      this.select('gizmo', 'Handles', [
        ['none', 'None'],
        ['move', 'Move'],
        ['rotate', 'Rotate'],
        ['scale', 'Scale'],
      ]),
      this.select('orientation', 'Axes', [
        ['world', 'World'],
        ['lattice', 'Lattice'],
        ['view', 'View'],
      ]),
      this.select('pivot', 'Pivot', [
        ['median', 'Median'],
        ['active', 'Active'],
        ['each', 'Each'],
      ]),
      field('Mirror', ...mirrors),
    ];
  }

  private mirrorSwitch(name: string, axis: Axis): HTMLElement {
    const get = (): boolean => this.settings.value.mirror[axis];
    const set = (on: boolean): void => {
      const mirror = [...this.settings.value.mirror] as [boolean, boolean, boolean];
      mirror[axis] = on;
      this.settings.set({ mirror });
    };
    return this.keep(toggle({ label: name, get, set }, `Mirror over ${name}`));
  }

  private softControls(): HTMLElement[] {
    const change = (part: Partial<Settings['soft']>): void =>
      this.settings.set({ soft: { ...this.settings.value.soft, ...part } });
    const enabled = toggle(
      {
        label: 'Nearby points follow',
        get: () => this.settings.value.soft.enabled,
        set: (on) => change({ enabled: on }),
      },
      'O',
    );
    const falloff = choice<Falloff>(
      { label: 'Falloff', get: () => this.settings.value.soft.falloff, set: (name) => change({ falloff: name }) },
      (Object.keys(FALLOFFS) as Falloff[]).map((name) => [name, name] as const),
    );
    return [this.keep(enabled), this.keep(this.radius), this.keep(falloff)];
  }

  private radiusSlider(): Control {
    const get = (): number => this.settings.value.soft.radius;
    const set = (radius: number): void => this.settings.set({ soft: { ...this.settings.value.soft, radius } });
    return slider({ label: 'Radius', get, set }, { min: 0, max: 1, step: 0.005 });
  }

  private surfaceControls(): HTMLElement[] {
    const colouring = choice(
      {
        label: 'Colour',
        get: () => this.settings.value.colouring,
        set: (name) => this.settings.set({ colouring: name }),
      },
      [
        ['plain', 'Shaded'],
        ['displacement', 'Displacement'],
        ['boxes', 'Knot boxes'],
        ['texture', 'Texture'],
      ],
    );
    return [
      this.keep(colouring),
      h(
        'div',
        { class: 'switches' },
        this.switch('surface', 'Surface'),
        this.switch('wireframe', 'Wireframe', 'Z'),
        this.switch('patchEdges', 'Patch edges'),
        this.switch('ghost', 'Rest shape'),
        this.switch('cage', 'Cage'),
        this.switch('knotBoxes', 'Box edges'),
      ),
    ];
  }

  private streamControls(): HTMLElement[] {
    const view = (): Required<ViewRequest> => this.settings.value.view;
    const change = (part: ViewRequest): void => this.settings.set({ view: { ...view(), ...part } });
    const bits = (
      key: 'segments' | 'positionBits' | 'normalBits',
      label: string,
      min: number,
      max: number,
      isIdle?: () => boolean,
    ): HTMLElement =>
      this.keep(
        slider({ label, get: () => view()[key], set: (n) => change({ [key]: n }), isIdle }, { min, max, step: 1 }, 'change'),
      );
    const encoding = choice(
      { label: 'Encoding', get: () => view().encoding, set: (name) => change({ encoding: name }) },
      (['draco', 'quantised', 'raw'] as const).map((name) => [name, LONGER[name]!] as const),
    );
    const normals = choice({ label: 'Normals', get: () => view().normals, set: (name) => change({ normals: name }) }, [
      ['smooth', 'Smooth'],
      ['facet', 'Facets'],
      ['none', 'None'],
    ]);
    return [
      bits('segments', 'Segments', 1, 32),
      this.keep(normals),
      this.keep(encoding),
      bits('positionBits', 'Position bits', 8, 16, () => view().encoding === 'raw'),
      bits('normalBits', 'Normal bits', 6, 12, () => view().encoding === 'raw' || view().normals === 'none'),
    ];
  }
}

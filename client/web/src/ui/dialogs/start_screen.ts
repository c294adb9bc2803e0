// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shown while the page has no scene: a place to drop a mesh, and samples to choose.
import { MESH_ENDINGS } from '../../intake/mesh_file';
import { SAMPLES, type SampleName } from '../../intake/samples';
import { button } from '../controls';
import type { RecentScene } from '../../state/recent_scenes';
import { h } from '../dom';
import { icon } from '../icons';

export interface StartChoices {
  files(files: File[]): void;
  sample(name: SampleName): void;
  scene(id: string): void;
}

/** Asks for files with the browser's dialog. */
export function chooseFiles(accept: string, chosen: (files: File[]) => void): void {
  const input = h('input', { type: 'file', accept, multiple: true, onchange: () => chosen([...(input.files ?? [])]) });
  input.click();
}

/** @param recent Scenes to open again, newest first. */
export function startScreen(choices: StartChoices, recent: readonly RecentScene[]): HTMLElement {
  const choose = (): void => chooseFiles(MESH_ENDINGS, (files) => files.length > 0 && choices.files(files));
  const browse = button(icon('open'), choose, { class: 'button primary' });
  browse.append('Open a mesh');
  const samples = (Object.keys(SAMPLES) as SampleName[]).map((name) => {
    const { label, note } = SAMPLES[name];
    return h(
      'button',
      { type: 'button', class: 'sample', 'data-sample': name, onclick: () => choices.sample(name) },
      h('b', {}, label),
      h('small', {}, note),
    );
  });
  const scenes = recent.map(({ id, name }) => button(name || id, () => choices.scene(id), { class: 'button', title: id }));
  return h(
    'section',
    { class: 'start', 'aria-label': 'Begin' },
    h('h1', {}, 'latticed'),
    h('p', {}, 'Bend a mesh by a lattice. The server evaluates the exact surface and streams it while you drag.'),
    h(
      'div',
      { class: 'start-drop' },
      icon('load'),
      h('p', {}, 'Drop an OBJ, PLY, STL, GLB or DRC file here'),
      h('p', { class: 'faint' }, 'and, with an OBJ or PLY, its MTL file and pictures'),
      browse,
    ),
    h('div', { class: 'samples', role: 'group', 'aria-label': 'Samples' }, h('span', {}, 'or a sample'), ...samples),
    scenes.length > 0 && h('div', { class: 'recent', role: 'group', 'aria-label': 'Recent scenes' }, h('span', {}, 'or a recent scene'), ...scenes),
  );
}

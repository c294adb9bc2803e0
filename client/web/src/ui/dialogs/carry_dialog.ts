// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks for a parent lattice, of a file or of the scene, that carries control points of the lattice that is shown: those that are
// selected, or all. The dialog stays until the server has carried them.
import type { Editor } from '../../edit/editor';
import { indicesTo } from '../../lattice/index_sets';
import type { Lattice } from '../../lattice/lattice';
import { effectiveLattice } from '../../lattice/outside';
import { carriedBy, isAtRest } from '../../lattice/parent';
import { latticeFromJson } from '../../wire/lattice_json';
import { inWords } from '../../wire/words';
import { button, choice, field } from '../controls';
import { h, onEnter, showBeside } from '../dom';
import { chooseFiles } from './start_screen';

const FILE = 'file';
const OF_FILE = 'Control points go where the parent moves them. Those outside of it stay.';
const OF_SCENE = `${OF_FILE} What both lattices move the mesh still adds up: remove the parent when it is done.`;

/** A parent lattice, from a file or from the other lattices of the scene. */
class ParentChoice {
  readonly element: HTMLElement;
  private chosen = FILE;
  private ofFile: Lattice | undefined;
  private reading = 0;
  private readonly name = h('span', { class: 'file-name' }, 'no file yet');
  private readonly file = field('File', button('Choose…', () => chooseFiles('.json', (files) => void this.read(files[0]))), this.name);

  /** `changed`: what is wrong with the file, if something is. */
  constructor(private readonly editor: Editor, private readonly changed: (problem: string) => void) {
    const { latticeNumbers: numbers, shownLatticeIndex } = editor.session;
    const others = numbers.flatMap((number, k) => (number === shownLatticeIndex ? [] : [[number, k + 1] as const]));
    const options = Object.fromEntries(others.map(([number, place]) => [String(number), `Lattice ${place} of ${numbers.length}`]));
    const from = choice<string>({ label: 'Parent', get: () => this.chosen, set: (chosen) => {
      this.chosen = chosen;
      this.file.hidden = chosen !== FILE;
      this.changed('');
    } }, { [FILE]: 'A file', ...options });
    from.element.hidden = others.length === 0;
    this.element = h('div', { class: 'parent-choice' }, from.element, this.file);
  }

  get isOfFile(): boolean {
    return this.chosen === FILE;
  }

  /** With all of its deformation in its control points. Undefined: none is chosen, or it was removed. */
  get lattice(): Lattice | undefined {
    if (this.isOfFile) return this.ofFile;
    const other = this.editor.session.numberedLattices.get(Number(this.chosen));
    return other && effectiveLattice(other);
  }

  private async read(file: File | undefined): Promise<void> {
    if (file === undefined) return;
    const turn = ++this.reading;
    let problem = '';
    let lattice: Lattice | undefined;
    try {
      lattice = latticeFromJson(await file.text());
    } catch (error) {
      problem = inWords(error);
    }
    if (turn !== this.reading) return; // another file was chosen meanwhile
    this.ofFile = lattice;
    this.name.textContent = this.name.title = file.name;
    this.changed(problem);
  }
}

/** How many control points go along, of those that are asked for; or why none does. */
function told(parent: Lattice | undefined, carried: number, asked: number, isAll: boolean): string {
  const which = isAll ? 'control points' : 'selected points';
  if (parent !== undefined && isAtRest(parent)) return 'The parent is at rest: it moves nothing.';
  if (parent !== undefined && carried === 0) return `None of the ${asked} ${which} is inside the parent.`;
  if (parent !== undefined && carried < asked) return `${carried} of ${asked} ${which} go along.`;
  return asked === 1 ? 'The selected point goes along.' : `All ${asked} ${which} go along.`;
}

/** Returns a function that closes the dialog. */
export function showCarryDialog(editor: Editor): () => void {
  const { session, selection } = editor;
  const facts = h('p', { class: 'facts', role: 'status' });
  const note = h('p', { class: 'note' });
  const problem = h('p', { class: 'error', role: 'alert' });
  const confirm = button('Carry', () => carry(), { class: 'button primary' });
  let isAsked = false;
  const show = (): void => {
    const isAll = selection.size === 0;
    const asked = isAll ? indicesTo(session.lattice.count) : [...selection.indices];
    const { lattice } = parent;
    const carried = lattice === undefined ? [] : carriedBy(lattice, session.lattice.points, asked);
    facts.textContent = told(lattice, carried.length, asked.length, isAll);
    note.textContent = parent.isOfFile ? OF_FILE : OF_SCENE;
    confirm.disabled = isAsked || carried.length === 0 || isAtRest(lattice!);
  };
  const parent = new ParentChoice(editor, (text) => {
    problem.textContent = text;
    show();
  });
  const carry = (): void => {
    show(); // the parent may have moved meanwhile
    if (confirm.disabled) return;
    confirm.disabled = isAsked = true;
    problem.textContent = '';
    session.carry(selection.indices, parent.lattice!, (refusal) => {
      isAsked = false;
      if (refusal === undefined) return dialog.close();
      problem.textContent = refusal;
      show();
    });
  };
  const dialog = showBeside(
    'Carry by a parent lattice', 'carry',
    h('h2', {}, 'Carry by a parent lattice'),
    parent.element, facts, note, problem,
    h('footer', {}, button('Cancel', () => dialog.close()), confirm));
  const ends = [
    session.on('lattice', () => dialog.close()), // it is another one
    session.on('points', show),
    selection.onChange(show),
  ];
  dialog.addEventListener('close', () => ends.forEach((end) => end()));
  onEnter(dialog, carry);
  show();
  return () => dialog.close();
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Quiet lines about the lattice, each with a button that selects the control points concerned. A closed line comes
// again only after its cause had gone.
import type { Remark } from '../../lattice/lattice_remarks';
import { button } from '../controls';
import { h } from '../dom';
import { icon } from '../icons';

export class Remarks {
  readonly element = h('div', { class: 'remarks', role: 'status' });
  private readonly lines = new Map<Remark['kind'], { line: HTMLElement; remark: Remark }>();
  private readonly closed = new Set<Remark['kind']>();

  constructor(private readonly select: (points: readonly number[]) => void) {}

  show(remarks: readonly Remark[]): void {
    const kinds = new Set(remarks.map(({ kind }) => kind));
    for (const kind of [...this.closed]) if (!kinds.has(kind)) this.closed.delete(kind);
    for (const kind of [...this.lines.keys()]) if (!kinds.has(kind)) this.remove(kind);
    for (const remark of remarks) if (!this.closed.has(remark.kind)) this.showOne(remark);
  }

  /** For another scene. */
  clear(): void {
    this.show([]);
  }

  /** A line stays where it is, so that its button keeps the focus. */
  private showOne(remark: Remark): void {
    const { kind, text } = remark;
    const shown = this.lines.get(kind);
    if (shown !== undefined) return void (shown.remark = remark);
    const where = button('Select', () => this.select(this.lines.get(kind)!.remark.points));
    const close = button(icon('close'), () => this.close(kind), { class: 'icon-button', 'aria-label': 'Close' });
    const line = h('div', { class: 'remark', 'data-remark': kind }, h('span', {}, text), where, close);
    this.lines.set(kind, { line, remark });
    this.element.append(line);
  }

  private close(kind: Remark['kind']): void {
    this.closed.add(kind);
    this.remove(kind);
  }

  private remove(kind: Remark['kind']): void {
    this.lines.get(kind)?.line.remove();
    this.lines.delete(kind);
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The world's axes as the camera sees them, in the view's corner. A press on an end looks from there.
import { distance, dot, scale, WORLD_BASIS, type Basis, type Vec3 } from '../../lattice/vec';
import { setAttributes, svg } from '../dom';

const REACH = 30;

interface End {
  readonly direction: Vec3;
  readonly group: SVGElement;
  readonly line?: SVGElement;
}

export class NavGizmo {
  readonly element = svg('svg', {
    viewBox: '-40 -40 80 80',
    class: 'nav-gizmo',
    role: 'group',
    'aria-label': 'Look along an axis',
  });
  private readonly ends: End[] = [];
  private view: Basis | undefined;

  constructor(lookFrom: (direction: Vec3) => void) {
    WORLD_BASIS.forEach((axis, i) => {
      const name = 'XYZ'[i];
      for (const sign of [1, -1]) {
        const direction = scale(axis, sign);
        const label = `${sign > 0 ? '+' : '−'}${name}`;
        const group = svg('g', {
          class: `nav-${name} ${sign > 0 ? '' : 'nav-back'}`,
          role: 'button',
          tabindex: 0,
          'aria-label': `Look from ${label}`,
        });
        group.append(svg('circle', { r: sign > 0 ? 8 : 6 }));
        if (sign > 0) {
          group.append(svg('text', { 'text-anchor': 'middle', dy: '0.35em' }));
          group.lastElementChild!.textContent = name;
        }
        const line = sign > 0 ? svg('line', { class: `nav-${name}` }) : undefined;
        group.addEventListener('click', () => lookFrom(direction));
        group.addEventListener('keydown', (event) => event.key === 'Enter' && lookFrom(direction));
        this.ends.push({ direction, group, line });
      }
    });
  }

  /** `view`: right, up and towards the viewer. */
  update(view: Basis): void {
    if (this.view?.every((axis, i) => distance(axis, view[i]) < 1e-6)) return; // redrawing would drop the focus
    this.view = view;
    const seen = this.ends.map((end) => ({
      end,
      x: dot(view[0], end.direction),
      y: -dot(view[1], end.direction),
      z: dot(view[2], end.direction),
    }));
    for (const { end, x, y } of seen) {
      end.group.setAttribute('transform', `translate(${(x * REACH).toFixed(2)} ${(y * REACH).toFixed(2)})`);
      if (end.line) setAttributes(end.line, { x2: (x * REACH).toFixed(2), y2: (y * REACH).toFixed(2) });
    }
    seen.sort((a, b) => a.z - b.z);
    this.element.replaceChildren(
      ...seen.flatMap(({ end }) => (end.line === undefined ? [end.group] : [end.line, end.group])),
    );
  }
}

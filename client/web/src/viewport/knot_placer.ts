// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shows a knot plane before it is inserted, and places it where the pointer hovers. A cover takes the pointer meanwhile.
import { KnotPlane } from '../cage/knot_plane';
import { evaluate } from '../lattice/bspline';
import { AXES, domain, type Axis } from '../lattice/grid';
import type { Lattice } from '../lattice/lattice';
import type { MutableVec3 } from '../lattice/vec';
import type { Viewport } from './viewport';

const STEPS = 100; // places along the axis: all but the ends are offered
const ACROSS = [0, 0.5, 1]; // fractions of the other axes, of the curves along which the pointer is followed

export class KnotPlacer {
  /** Called when the pointer hovers at another knot, and when it chooses the knot by a click. */
  onHover?: (knot: number) => void;
  onChosen?: () => void;
  private readonly plane = new KnotPlane();
  private readonly cover = document.createElement('div');
  private axis: Axis = 0;

  constructor(private readonly viewport: Viewport, private readonly lattice: () => Lattice) {
    this.cover.className = 'overlay knot-cover';
    this.cover.addEventListener('pointermove', (event) => this.onHover?.(this.knotAt(...viewport.place(event))));
    // A finger has not hovered: it places the plane by a tap, and a button inserts it.
    this.cover.addEventListener('click', (event) => (event as PointerEvent).pointerType !== 'touch' && this.onChosen?.());
    viewport.element.append(this.cover);
    viewport.scene.add(this.plane.object);
  }

  show(axis: Axis, knot: number): void {
    this.axis = axis;
    this.plane.place(this.lattice(), axis, knot);
    this.viewport.invalidate();
  }

  dispose(): void {
    this.cover.remove();
    this.plane.dispose();
    this.viewport.invalidate();
  }

  /** The knot whose plane is nearest to a place of the view. */
  private knotAt(x: number, y: number): number {
    const lattice = this.lattice();
    const [begin, end] = domain(lattice, this.axis);
    const knots = Array.from({ length: STEPS - 1 }, (_, i) => begin + ((i + 1) / STEPS) * (end - begin));
    const points = Float64Array.from(knots.flatMap((knot) => this.across(lattice, knot)));
    const places = this.viewport.projectAll(points);
    let [best, least] = [0, Infinity];
    for (let i = 0; i < places.length; i += 3) {
      const away = Math.hypot(places[i] - x, places[i + 1] - y);
      if (away < least) [best, least] = [i, away];
    }
    return knots[Math.floor(best / (3 * ACROSS.length ** 2))];
  }

  /** Points of the plane at a knot: on its border and in its middle. */
  private across(lattice: Lattice, knot: number): number[] {
    const [a, b] = AXES.filter((axis) => axis !== this.axis);
    const at = (axis: Axis, fraction: number): number => {
      const [begin, end] = domain(lattice, axis);
      return begin + fraction * (end - begin);
    };
    return ACROSS.flatMap((s) => ACROSS.flatMap((t) => {
      const parameter: MutableVec3 = [0, 0, 0];
      parameter[this.axis] = knot;
      parameter[a] = at(a, s);
      parameter[b] = at(b, t);
      return evaluate(lattice, parameter);
    }));
  }
}

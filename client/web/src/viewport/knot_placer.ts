// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shows a knot plane before it is inserted, and places it where the pointer hovers. A cover over the canvas keeps the pointer
// from control points meanwhile, and gives drags and the wheel to the camera.
import { KnotPlane } from '../cage/knot_plane';
import { evaluate } from '../lattice/bspline';
import { AXES, domain, type Axis } from '../lattice/grid';
import type { Lattice } from '../lattice/lattice';
import type { MutableVec3 } from '../lattice/vec';
import type { Viewport } from './viewport';

const SLACK = 4; // pixels that the pointer may move in a click
const STEPS = 100; // places along the axis: all but the ends are offered
const ACROSS = [0, 0.5, 1]; // fractions of the other axes, of the curves along which the pointer is followed

export class KnotPlacer {
  /** Called when the pointer hovers at another knot, and when it chooses the knot by a click. */
  onHover?: (knot: number) => void;
  onChosen?: () => void;
  private readonly plane = new KnotPlane();
  private readonly cover = document.createElement('div');
  private readonly abort = new AbortController();
  private press: PointerEvent | undefined;
  private axis: Axis = 0;

  constructor(private readonly viewport: Viewport, private readonly lattice: () => Lattice) {
    this.cover.className = 'overlay knot-cover';
    this.cover.addEventListener('pointermove', (event) => this.hover(event));
    this.cover.addEventListener('pointerdown', (event) => this.down(event));
    this.cover.addEventListener('wheel', (event) => this.zoom(event), { passive: false });
    this.cover.addEventListener('contextmenu', (event) => event.preventDefault()); // the right button pans
    window.addEventListener('pointerup', (event) => this.up(event), { signal: this.abort.signal }); // the canvas has captured it
    viewport.element.prepend(this.cover); // above the canvas, and below all else on the view
    viewport.scene.add(this.plane.object);
  }

  show(axis: Axis, knot: number): void {
    this.axis = axis;
    this.plane.place(this.lattice(), axis, knot);
    this.viewport.invalidate();
  }

  dispose(): void {
    this.abort.abort();
    this.cover.remove();
    this.plane.dispose();
    this.viewport.invalidate();
  }

  private hover(event: PointerEvent): void {
    if (event.buttons === 0) this.onHover?.(this.knotAt(...this.viewport.place(event)));
  }

  private down(event: PointerEvent): void {
    if (event.isPrimary) this.press = event;
    this.viewport.canvas.dispatchEvent(new PointerEvent('pointerdown', event));
  }

  /** A click inserts the plane. A finger has not hovered: it places the plane by a tap, and a button inserts it. */
  private up(event: PointerEvent): void {
    const { press } = this;
    if (press?.pointerId !== event.pointerId) return;
    this.press = undefined;
    const isClick = Math.hypot(event.clientX - press.clientX, event.clientY - press.clientY) <= SLACK;
    if (!isClick || press.button !== 0) return;
    if (event.pointerType === 'touch') this.onHover?.(this.knotAt(...this.viewport.place(event)));
    else this.onChosen?.();
  }

  private zoom(event: WheelEvent): void {
    event.preventDefault();
    this.viewport.canvas.dispatchEvent(new WheelEvent('wheel', event));
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

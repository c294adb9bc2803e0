// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Handles in the middle of the six faces of a box. The box reaches beyond a lattice's frame, or lies within it, by a width at each
// side. Each is dragged, or moved by arrow keys, along its axis, which changes the width of its side.
import { middleOfSide, OutsideBox } from '../cage/outside_box';
import { AXIS_NAMES } from '../lattice/grid';
import type { LatticeFrame } from '../lattice/lattice';
import { allowedWidth } from '../lattice/outside';
import type { Vec3 } from '../lattice/vec';
import { h } from '../ui/dom';
import type { Viewport } from './viewport';

const STEP = 0.05; // of an arrow key, in lengths of the frame's edge

/**
 * By how much a width changes when the pointer moves by (dx, dy) pixels, where the edge of the frame seen from its face outwards
 * is (ex, ey) pixels long. An edge that points at the eye has no direction on the screen: nothing moves.
 */
export function widthChange(dx: number, dy: number, ex: number, ey: number): number {
  const length = ex * ex + ey * ey;
  return length < 1 ? 0 : (dx * ex + dy * ey) / length;
}

export class OutsideHandles {
  /** Called with the side and its new width. */
  onDragged?: (side: number, width: number) => void;
  private readonly box = new OutsideBox();
  private readonly overlay = h('div', { class: 'overlay outside-handles' });
  private readonly handles: readonly HTMLElement[];
  private readonly endFrame: () => void;
  private widths: readonly number[] = [0, 0, 0, 0, 0, 0];
  private drag: { readonly side: number; readonly width: number; readonly x: number; readonly y: number } | undefined;

  /** @param allowed The width nearest to one that is wanted. @param what What the names of the handles call a width. */
  constructor(
    private readonly viewport: Viewport,
    private frame: LatticeFrame,
    private readonly allowed: (width: number) => number = allowedWidth,
    private readonly what = 'Width',
  ) {
    this.handles = [0, 1, 2, 3, 4, 5].map((side) => this.handle(side));
    this.overlay.append(...this.handles);
    viewport.element.prepend(this.overlay); // above the canvas, and below all else on the view
    viewport.scene.add(this.box.object);
    this.endFrame = viewport.onFrame(() => this.place());
  }

  show(widths: readonly number[], isVisible: boolean): void {
    this.widths = widths;
    this.box.place(this.frame, widths);
    this.box.object.visible = isVisible;
    this.overlay.hidden = !isVisible;
    this.handles.forEach((handle, side) => handle.setAttribute('aria-valuenow', widths[side]!.toPrecision(3)));
    this.place();
    this.viewport.invalidate();
  }

  /** The box is one about this frame from now on. */
  moveTo(frame: LatticeFrame): void {
    this.frame = frame;
    this.show(this.widths, !this.overlay.hidden);
  }

  dispose(): void {
    this.endFrame();
    this.overlay.remove();
    this.box.dispose();
    this.viewport.invalidate();
  }

  private handle(side: number): HTMLElement {
    const name = `${this.what} at the ${side % 2 === 0 ? 'begin' : 'end'} of ${AXIS_NAMES[Math.floor(side / 2)]}`;
    const handle = h('div', { class: 'outside-handle', role: 'slider', tabindex: 0, 'aria-label': name, title: name, 'data-side': side });
    handle.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      handle.focus({ preventScroll: true });
      handle.setPointerCapture(event.pointerId);
      this.drag = { side, width: this.widths[side]!, x: event.clientX, y: event.clientY };
    });
    handle.addEventListener('pointermove', (event) => this.dragged(event));
    for (const end of ['pointerup', 'pointercancel'] as const) handle.addEventListener(end, () => (this.drag = undefined));
    handle.addEventListener('keydown', (event) => {
      const by = { ArrowUp: STEP, ArrowRight: STEP, ArrowDown: -STEP, ArrowLeft: -STEP }[event.key];
      if (by === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      this.onDragged?.(side, this.allowed(this.widths[side]! + by));
    });
    return handle;
  }

  private dragged({ clientX, clientY }: PointerEvent): void {
    const { drag } = this;
    if (drag === undefined) return;
    const [ex, ey] = this.outwards(drag.side);
    this.onDragged?.(drag.side, this.allowed(drag.width + widthChange(clientX - drag.x, clientY - drag.y, ex, ey)));
  }

  /** The frame's edge of a side, from its face outwards, in pixels. */
  private outwards(side: number): [number, number] {
    const base = new Array<number>(6).fill(0);
    const from = this.viewport.project(middleOfSide(this.frame, base, side));
    base[side] = 1;
    const to = this.viewport.project(middleOfSide(this.frame, base, side));
    return from && to ? [to[0] - from[0], to[1] - from[1]] : [0, 0];
  }

  private place(): void {
    this.handles.forEach((handle, side) => {
      const at: Vec3 | undefined = this.viewport.project(middleOfSide(this.frame, this.widths, side));
      handle.hidden = at === undefined;
      if (at) handle.style.translate = `${at[0]}px ${at[1]}px`;
    });
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The control points that are selected, active or hidden. Hidden points are never selected.

import { indicesTo } from '../lattice/index_sets';
import { Signal } from '../state/signal';

export type SelectMode = 'replace' | 'extend' | 'toggle' | 'remove';

export class Selection {
  private selected = new Set<number>();
  private hiddenPoints = new Set<number>();
  private activePoint: number | undefined;
  private sorted: Uint32Array | undefined;
  private readonly signal = new Signal();
  /** Calls a listener after every change; the function returned removes it. */
  readonly onChange = this.signal.on;

  /** `count` control points, none of them selected. */
  constructor(private points: number) {}

  /** The number of all control points. */
  get count(): number {
    return this.points;
  }

  /** The selected points, ascending. */
  get indices(): Uint32Array {
    return (this.sorted ??= Uint32Array.from(this.selected).sort());
  }

  get size(): number {
    return this.selected.size;
  }

  /** The point that was selected last, or another selected point after that one was removed: the pivot 'active'. */
  get active(): number | undefined {
    return this.activePoint;
  }

  get hiddenCount(): number {
    return this.hiddenPoints.size;
  }

  has(index: number): boolean {
    return this.selected.has(index);
  }

  isHidden(index: number): boolean {
    return this.hiddenPoints.has(index);
  }

  /** Starts again with another number of points, after a change of the lattice's structure. */
  reset(count: number): void {
    this.points = count;
    this.selected.clear();
    this.hiddenPoints.clear();
    this.activePoint = undefined;
    this.changed();
  }

  /** Applies a click on one point, a box or a row. The last of `indices` becomes active if it ends selected. */
  select(indices: Iterable<number>, mode: SelectMode = 'replace'): void {
    const named = [...indices].filter((i) => !this.hiddenPoints.has(i));
    if (mode === 'replace') this.selected.clear();
    for (const index of named) {
      const remove = mode === 'remove' || (mode === 'toggle' && this.selected.has(index));
      if (remove) this.selected.delete(index);
      else this.selected.add(index);
    }
    const last = named[named.length - 1];
    if (last !== undefined && this.selected.has(last)) this.activePoint = last;
    this.keepActive();
    this.changed();
  }

  all(): void {
    this.select(this.visible(), 'extend');
  }

  none(): void {
    this.select([]);
  }

  invert(): void {
    this.select(this.visible(), 'toggle');
  }

  hide(indices: Iterable<number>): void {
    for (const index of indices) {
      this.hiddenPoints.add(index);
      this.selected.delete(index);
    }
    this.keepActive();
    this.changed();
  }

  /** Shows all points again. */
  reveal(): void {
    this.hiddenPoints.clear();
    this.changed();
  }

  private visible(): number[] {
    return indicesTo(this.points).filter((i) => !this.hiddenPoints.has(i));
  }

  private keepActive(): void {
    if (this.activePoint !== undefined && this.selected.has(this.activePoint)) return;
    this.activePoint = [...this.selected].pop();
  }

  private changed(): void {
    this.sorted = undefined;
    this.signal.emit();
  }
}

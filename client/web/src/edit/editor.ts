// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a person does to a scene's lattice, without the page: selects, transforms, hides, by keys, pointer or buttons.
import { frameEdges, type Axis } from '../lattice/grid';
import { innerPoints, planeOf, rowOf } from '../lattice/index_sets';
import type { Lattice } from '../lattice/lattice';
import { normalized, sub, type Basis, type Vec3 } from '../lattice/vec';
import type { SceneSession } from '../session/scene_session';
import type { SettingsStore } from '../state/settings';
import { beginSpread } from './build_edit';
import { transformHeadline } from './headline';
import type { MotionKind } from './motion';
import { orientationBasis, pivotPoint } from './pivot';
import { Selection, type SelectMode } from './selection';
import { TransformGesture } from './transform_gesture';
import { TransformSession, type Modifiers, type TransformView } from './transform_session';

/** Gives the view at a pivot, for axes and, pressed twice, the lattice's own. */
export type ViewAt = (pivot: Vec3, axes: Basis, localAxes: Basis) => TransformView;

interface Running {
  transform: TransformSession;
  gesture: TransformGesture;
}

export class Editor {
  readonly selection: Selection;
  private running: Running | undefined;

  constructor(
    readonly session: SceneSession,
    readonly settings: SettingsStore,
    /** Called when the line below the view says something else; undefined: nothing runs. */
    private readonly onHeadline: (text: string | undefined) => void,
  ) {
    this.selection = new Selection(session.lattice.count);
    this.selection.onChange(() => session.announce(this.selection.indices));
  }

  get lattice(): Lattice {
    return this.session.lattice;
  }

  /** Whether a transform runs that takes the pointer and the keys. */
  get transforming(): boolean {
    return this.running !== undefined;
  }

  /** Begins anew after a change of the lattice's structure. */
  latticeReplaced(): void {
    this.cancelTransform();
    if (this.lattice.count === this.selection.count) return;
    this.selection.reset(this.lattice.count);
  }

  /** Selects the row along an axis, or the plane across it, through every selected point. */
  selectRows(axis: Axis, plane: boolean, mode: SelectMode = 'replace'): void {
    const through = plane ? planeOf : rowOf;
    const found = new Set<number>();
    for (const index of this.selection.indices) for (const i of through(this.lattice.size, index, axis)) found.add(i);
    const active = this.selection.active;
    if (active !== undefined) found.delete(active);
    this.selection.select([...found, ...(active === undefined ? [] : [active])], mode);
  }

  hideInner(): void {
    this.selection.hide(innerPoints(this.lattice.size));
  }

  /** Where turns and scalings are about. */
  pivot(): Vec3 {
    return pivotPoint(this.lattice.points, this.selection.indices, this.settings.value.pivot, this.selection.active);
  }

  axes(view: Basis): Basis {
    return orientationBasis(this.settings.value.orientation, this.lattice, view);
  }

  /** A gesture on the selected points; undefined where there are none. */
  beginGesture(): TransformGesture | undefined {
    if (this.selection.size === 0) return undefined;
    const { soft, mirror, pivot } = this.settings.value;
    const isHidden = (index: number): boolean => this.selection.isHidden(index);
    const spread = beginSpread(this.lattice, this.selection.indices, { soft, mirror, pivot }, isHidden);
    return new TransformGesture(this.session, spread, this.pivot());
  }

  /** Begins G, R or S; false where nothing is selected. */
  beginTransform(kind: MotionKind, viewAt: ViewAt, viewBasis: Basis, pointer: [number, number]): boolean {
    this.commitTransform();
    const gesture = this.beginGesture();
    if (gesture === undefined) return false;
    const localAxes = frameEdges(this.lattice.frame).map(normalized) as unknown as Basis;
    const view = viewAt(gesture.center, this.axes(viewBasis), localAxes);
    this.running = { transform: new TransformSession(kind, view, pointer), gesture };
    this.update();
    return true;
  }

  pointerMoved(x: number, y: number, modifiers: Modifiers): void {
    this.running?.transform.pointer(x, y, modifiers);
    this.update();
  }

  /** Gives a key to the running transform; says whether it was taken. */
  keyPressed(key: string, shift: boolean): boolean {
    const outcome = this.running?.transform.key(key, shift);
    if (outcome === 'confirmed') this.commitTransform();
    else if (outcome === 'cancelled') this.cancelTransform();
    else this.update();
    return outcome !== undefined;
  }

  commitTransform(): void {
    const gesture = this.running?.gesture;
    this.running = undefined;
    gesture?.commit();
    this.onHeadline(undefined);
  }

  cancelTransform(): void {
    const gesture = this.running?.gesture;
    this.running = undefined;
    gesture?.cancel();
    this.onHeadline(undefined);
  }

  /** Moves the selected points so that their pivot comes to a place. */
  movePivotTo(place: Vec3): void {
    const gesture = this.beginGesture();
    gesture?.update({ kind: 'move', offset: sub(place, gesture.center) });
    gesture?.commit();
  }

  /** The middle of the widest knot interval along an axis: a good place for one more knot. */
  knotBetween(axis: Axis): number {
    const knots = this.lattice.knots[axis];
    let [widest, middle] = [0, 0];
    for (let i = this.lattice.degree[axis]; i < this.lattice.size[axis]; ++i) {
      const width = knots[i + 1] - knots[i];
      if (width > widest * (1 + 1e-9)) [widest, middle] = [width, (knots[i] + knots[i + 1]) / 2];
    }
    return middle;
  }

  private update(): void {
    if (this.running === undefined) return;
    const { transform, gesture } = this.running;
    const motion = transform.motion();
    gesture.update(motion);
    this.onHeadline(
      transformHeadline(motion, transform.constraint, this.settings.value.orientation, transform.typed.text),
    );
  }
}

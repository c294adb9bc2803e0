// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edits of a person to a scene's lattice, without the page: select, transform, hide, by keys, pointer or buttons.
import { AXES, type Axes, type Axis } from '../lattice/grid';
import { innerPoints, planeOf, rowOf } from '../lattice/index_sets';
import type { Lattice } from '../lattice/lattice';
import { sub, type Basis, type Vec3 } from '../lattice/vec';
import type { LiveSession } from '../session/live_session';
import type { SettingsStore } from '../state/settings';
import { beginSpread, respread } from './build_edit';
import { secondOrientation, type Constraint } from './constraint';
import type { Mirror } from './mirror';
import { transformHeadline } from './headline';
import type { MotionKind } from './motion';
import { orientationBasis, pivotPoint } from './pivot';
import { axesInView, foremost, nextPoint, type StepKey } from './point_steps';
import { Selection, type SelectMode } from './selection';
import { TransformGesture } from './transform_gesture';
import { TransformSession, type Modifiers, type TransformView } from './transform_session';

/** Gives the view at a pivot, for the chosen axes and for the axes of a key that is pressed twice. */
export type ViewAt = (pivot: Vec3, axes: Basis, secondAxes: Basis) => TransformView;

const RADIUS_STEP = 1.1;
/** Keys that change the soft radius while a transform runs, and the steps by which they do. */
const RADIUS_KEYS: Record<string, number> = { PageUp: 1, PageDown: -1, ']': 1, '[': -1 };

interface Running {
  transform: TransformSession;
  gesture: TransformGesture;
}

export class Editor {
  readonly selection: Selection;
  private running: Running | undefined;
  /** The lattice's size that the selection's indices are of. */
  private size: Axes;
  private latticeIndex: number;
  private readonly endSettings: () => void;
  private held: Modifiers = { shift: false, ctrl: false };
  private gesture: TransformGesture | undefined; // the newest one, begun by keys or handles

  constructor(
    readonly session: LiveSession,
    readonly settings: SettingsStore,
    /** Called when the line below the view changes; undefined: no transform runs. */
    private readonly onHeadline: (text: string | undefined) => void,
  ) {
    this.size = session.lattice.size;
    this.latticeIndex = session.shownLatticeIndex;
    this.selection = new Selection(session.lattice.count);
    this.selection.onChange(() => session.announce({ selected: this.selection.indices, lattice: session.shownLatticeIndex }));
    this.endSettings = settings.subscribe((now, before) => now.soft !== before.soft && this.spreadAnew());
  }

  dispose(): void {
    this.endSettings();
  }

  get lattice(): Lattice {
    return this.session.lattice;
  }

  /** Whether a transform runs that takes the pointer and the keys. */
  get transforming(): boolean {
    return this.running !== undefined;
  }

  /** The constraint of the running transform. */
  get constraint(): Constraint | undefined {
    return this.running?.transform.constraint;
  }

  /** Cancels the transform after a change of structure. Another size, or another lattice, also resets the selection. */
  latticeReplaced(): void {
    this.cancelTransform();
    const { size } = this.lattice;
    const { shownLatticeIndex: latticeIndex } = this.session;
    if (latticeIndex === this.latticeIndex && AXES.every((axis) => size[axis] === this.size[axis])) return;
    this.size = size;
    this.latticeIndex = latticeIndex;
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

  /** Selects the next point from the active one; without one, the point nearest to the viewer. */
  step({ direction, sign }: StepKey, view: Basis, mode: SelectMode): void {
    const { size, frame, points } = this.lattice;
    const { active } = this.selection;
    const along = axesInView(frame, view)[direction];
    const next = active === undefined
      ? foremost(points, view[2], this.isHidden)
      : nextPoint(size, active, along.axis, sign === along.sign ? 1 : -1, this.isHidden);
    if (next !== undefined) this.selection.select([next], mode);
  }

  hideInner(): void {
    this.selection.hide(innerPoints(this.lattice.size));
  }

  /** The point that turns and scalings are about. */
  pivot(): Vec3 {
    return pivotPoint(this.lattice.points, this.selection.indices, this.settings.value.pivot, this.selection.active);
  }

  axes(view: Basis): Basis {
    return orientationBasis(this.settings.value.orientation, this.lattice, view);
  }

  /** Multiplies the soft radius by 1.1 for each step; negative steps divide it. */
  resizeSoft(steps: number): void {
    const { soft } = this.settings.value;
    this.settings.set({ soft: { ...soft, radius: soft.radius * RADIUS_STEP ** steps } });
  }

  /** Begins a gesture on the selected points, if there are any and they may be moved. `onEnded` is called if the session ends it. */
  beginGesture(onEnded?: () => void): TransformGesture | undefined {
    const { held, constraints } = this.session;
    const selected = this.selection.indices.filter((index) => !held.has(index));
    if (selected.length === 0 || !this.session.mayEdit) return undefined;
    const { soft, pivot } = this.settings.value;
    const mirror = this.settings.value.mirror.map((on, axis) => on || axis === constraints.mirror) as unknown as Mirror;
    const stays = (index: number): boolean => held.has(index) || this.isHidden(index);
    const spread = beginSpread(this.lattice, selected, { soft, mirror, pivot }, stays);
    this.gesture = new TransformGesture(this.session, spread, this.pivot(), onEnded);
    return this.gesture;
  }

  /** Begins the transform of G, R or S; false if nothing is selected. */
  beginTransform(kind: MotionKind, viewAt: ViewAt, viewBasis: Basis, pointer: [number, number]): boolean {
    this.commitTransform();
    const gesture = this.beginGesture(() => this.stopTransform());
    if (gesture === undefined) return false;
    const second = orientationBasis(secondOrientation(this.settings.value.orientation), this.lattice, viewBasis);
    const view = viewAt(gesture.center, this.axes(viewBasis), second);
    this.running = { transform: new TransformSession(kind, view, pointer), gesture };
    this.update();
    return true;
  }

  pointerMoved(x: number, y: number, { shift, ctrl }: Modifiers): void {
    this.running?.transform.pointer(x, y, { shift: shift || this.held.shift, ctrl: ctrl || this.held.ctrl });
    this.update();
  }

  /** Acts as if Shift (fine) or Ctrl (snap) were held, for a page without a keyboard. */
  hold(held: Modifiers): void {
    this.held = held;
  }

  /** Replaces the number that is being typed for the running transform. */
  typeAmount(text: string): void {
    this.running?.transform.typed.replace(text);
    this.update();
  }

  /** The pointer continues from another place, as a finger does that comes down again. */
  pointerResumed(x: number, y: number): void {
    this.running?.transform.resume(x, y);
  }

  /** Gives a key to the running transform. Returns whether the key was taken. */
  keyPressed(key: string, shift: boolean): boolean {
    if (this.softKey(key)) return true;
    const outcome = this.running?.transform.key(key, shift);
    if (outcome === 'confirmed') this.commitTransform();
    else if (outcome === 'cancelled') this.cancelTransform();
    else this.update();
    return outcome !== undefined;
  }

  commitTransform(): void {
    this.running?.gesture.commit();
    this.stopTransform();
  }

  cancelTransform(): void {
    this.running?.gesture.cancel();
    this.stopTransform();
  }

  /** Moves the selected points so that their pivot comes to `place`. */
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

  private readonly isHidden = (index: number): boolean => this.selection.isHidden(index);

  /** Keys of soft selection while a transform runs, as in Blender: the radius, and O for on or off. */
  private softKey(key: string): boolean {
    const { soft } = this.settings.value;
    const steps = RADIUS_KEYS[key];
    if (steps !== undefined) this.resizeSoft(steps);
    else if (key.toLowerCase() === 'o') this.settings.set({ soft: { ...soft, enabled: !soft.enabled } });
    else return false;
    return true;
  }

  private stopTransform(): void {
    this.running = undefined;
    this.onHeadline(undefined);
  }

  private spreadAnew(): void {
    const { soft } = this.settings.value;
    if (this.gesture?.isRunning) this.gesture.respread((spread) => respread(spread, soft, this.isHidden));
  }

  private update(): void {
    if (this.running === undefined) return;
    const { transform, gesture } = this.running;
    gesture.update(transform.motion());
    this.onHeadline(transformHeadline(transform, this.settings.value.orientation));
  }
}

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Handles at the selected points: three's TransformControls move a stand-in, and its change is reported as a motion.
import { Matrix4, Object3D, OrthographicCamera, Quaternion, Vector3 } from 'three';
import { TransformControls } from 'three/examples/jsm/controls/TransformControls.js';
import type { Constraint } from '../edit/constraint';
import type { Motion, MotionKind } from '../edit/motion';
import { AXES } from '../lattice/grid';
import { cross, dot, normalized, scale, sub, WORLD_BASIS, type Basis, type Vec3 } from '../lattice/vec';
import type { Viewport } from './viewport';

const SIZE = 0.9; // relative to three's default
const FACING = Math.cos(Math.PI / 9); // an axis within 20 degrees of the line of sight faces the eye
const MODES = { move: 'translate', rotate: 'rotate', scale: 'scale' } as const;

type Turn = Extract<Motion, { kind: 'rotate' }>;

export interface GizmoEvents {
  begin(): void;
  /** `constraint`: the axis or plane of the handle. */
  update(motion: Motion, constraint: Constraint | undefined): void;
  end(): void;
  /** Called instead of end(): the gesture must have no effect. */
  cancel(): void;
}

export class Gizmo {
  private readonly controls: TransformControls;
  private readonly standIn = new Object3D();
  private readonly start = { position: new Vector3(), quaternion: new Quaternion() };
  private cancelling = false;
  private kind: MotionKind = 'move';
  private basis = WORLD_BASIS;

  constructor(private readonly viewport: Viewport, private readonly events: GizmoEvents) {
    this.controls = new TransformControls(viewport.rig.camera, viewport.canvas);
    this.controls.setSpace('local');
    this.controls.setColors(0xe5534b, 0x6fae3c, 0x4a8fe8, 0xffc24d);
    const helper = this.controls.getHelper();
    const update = helper.updateMatrixWorld.bind(helper);
    helper.updateMatrixWorld = (force) => {
      update(force); // shows all handles
      this.hideFacingAxes();
    };
    viewport.scene.add(this.standIn, helper);
    this.controls.addEventListener('change', () => viewport.invalidate());
    this.controls.addEventListener('objectChange', () => this.events.update(this.motion(), this.constraint()));
    this.controls.addEventListener('dragging-changed', ({ value }) => this.draggingChanged(value === true));
  }

  /** Whether a press here is for a handle. A finger presses without having hovered. */
  takes(place: readonly [number, number]): boolean {
    if (this.controls.object === undefined) return false;
    const { width, height } = this.viewport.size;
    this.controls.pointerHover({
      x: (place[0] / width) * 2 - 1,
      y: 1 - (place[1] / height) * 2,
      button: 0,
    } as PointerEvent);
    return this.busy;
  }

  /** Whether the pointer is on a handle or drags one. */
  get busy(): boolean {
    return this.controls.object !== undefined && (this.controls.axis !== null || this.controls.dragging);
  }

  /** Whether a handle is held. */
  get dragging(): boolean {
    return this.controls.dragging;
  }

  /** Releases a handle without an effect. Returns whether one was held. */
  cancel(): boolean {
    if (!this.controls.dragging) return false;
    this.cancelling = true;
    this.controls.reset();
    this.controls.pointerUp(null);
    this.cancelling = false;
    return true;
  }

  /** Whether handles react to presses and are marked below the pointer. */
  setEnabled(on: boolean): void {
    if (this.controls.dragging) return;
    this.controls.enabled = on;
    if (!on) this.controls.axis = null;
  }

  /** Puts the handles at a place, along axes that are made orthogonal if they are not. */
  show(kind: MotionKind, place: Vec3, axes: Basis): void {
    if (this.controls.dragging) return;
    this.kind = kind;
    this.basis = orthonormal(axes);
    const [x, y, z] = this.basis.map((axis) => new Vector3(...axis));
    this.standIn.position.set(...place);
    this.standIn.quaternion.setFromRotationMatrix(new Matrix4().makeBasis(x, y, z));
    this.standIn.scale.setScalar(1);
    this.standIn.updateMatrixWorld();
    this.controls.camera = this.viewport.rig.camera;
    // three scales by the height alone: on an upright tablet the handles would fill half the screen.
    this.controls.size = SIZE * Math.min(this.viewport.size.width / this.viewport.size.height, 1);
    this.controls.setMode(MODES[kind]);
    this.controls.attach(this.standIn);
  }

  hide(): void {
    if (!this.controls.dragging) this.controls.detach();
  }

  dispose(): void {
    this.controls.detach();
    this.controls.dispose();
    this.viewport.scene.remove(this.standIn, this.controls.getHelper());
  }

  /** Moves snap to steps in world units, turns to 5 degrees, scalings to tenths. Undefined: no snapping. */
  setSnapping(step: number | undefined): void {
    this.controls.setTranslationSnap(step ?? null);
    this.controls.setRotationSnap(step === undefined ? null : Math.PI / 36);
    this.controls.setScaleSnap(step === undefined ? null : 0.1);
  }

  /** Axes towards the eye are neither drawn nor take a press: a pixel of the pointer would be a long way on them. */
  private hideFacingAxes(): void {
    if (this.kind === 'rotate' || this.controls.dragging) return;
    const { camera } = this.viewport.rig;
    const towards = sub(camera.position.toArray() as Vec3, this.standIn.position.toArray() as Vec3);
    const eye = camera instanceof OrthographicCamera ? this.viewport.rig.basis()[2] : normalized(towards);
    const hidden = AXES.filter((axis) => Math.abs(dot(this.basis[axis], eye)) > FACING).map((axis) => 'XYZ'[axis]);
    this.controls.getHelper().traverse((handle) => {
      if (hidden.includes(handle.name)) handle.visible = false;
    });
  }

  private draggingChanged(on: boolean): void {
    this.viewport.rig.controls.enabled = !on;
    if (!on) return this.cancelling ? this.events.cancel() : this.events.end();
    this.start.position.copy(this.standIn.position);
    this.start.quaternion.copy(this.standIn.quaternion);
    this.events.begin();
  }

  /** The axis or plane of the held handle; undefined for those in the middle and around all. */
  private constraint(): Constraint | undefined {
    const held = AXES.filter((axis) => this.controls.axis?.includes('XYZ'[axis]));
    if (held.length === 1) return { axis: held[0], plane: false, second: false };
    if (held.length === 2) return { axis: AXES.find((axis) => !held.includes(axis))!, plane: true, second: false };
    return undefined;
  }

  /** The same turn, about the direction of the held handle's axis. */
  private along(turn: Turn): Turn {
    const axis = this.constraint()?.axis;
    if (axis === undefined || dot(turn.axis, this.basis[axis]) >= 0) return turn;
    return { kind: 'rotate', axis: scale(turn.axis, -1), angle: -turn.angle };
  }

  private motion(): Motion {
    switch (this.kind) {
      case 'move':
        return { kind: 'move', offset: this.standIn.position.clone().sub(this.start.position).toArray() as Vec3 };
      case 'rotate':
        return this.along(rotationBetween(this.start.quaternion, this.standIn.quaternion));
      case 'scale':
        return { kind: 'scale', basis: this.basis, factors: this.standIn.scale.toArray() as Vec3 };
    }
  }
}

function rotationBetween(from: Quaternion, to: Quaternion): Turn {
  const turn = to.clone().multiply(from.clone().invert()).normalize();
  const angle = 2 * Math.atan2(Math.hypot(turn.x, turn.y, turn.z), turn.w);
  const axis = normalized([turn.x, turn.y, turn.z]);
  return { kind: 'rotate', axis, angle: angle > Math.PI ? angle - 2 * Math.PI : angle };
}

/** A right-handed frame whose first axis has the direction of the given one. */
function orthonormal([a, b]: Basis): Basis {
  const x = normalized(a);
  const y = normalized(sub(b, scale(x, dot(b, x))));
  return [x, y, cross(x, y)];
}

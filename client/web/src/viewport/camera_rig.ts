// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The two cameras, perspective and orthographic, which show the same part of the world, and the orbit around it.
import { Box3, MOUSE, OrthographicCamera, PerspectiveCamera, Sphere, TOUCH, Vector3 } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { add, scale, WORLD_BASIS, type Basis, type Vec3 } from '../lattice/vec';
import type { CameraPose } from '../state/camera_pose';
import { uprightDirection, type UpAxis } from '../state/units';
import type { Sight } from './sight';

const FIELD_OF_VIEW = 40; // degrees, of the shorter side
const MARGIN = 1.14; // the view is larger than the framed box by this factor, since the head-up line covers its edge
const FROM: Vec3 = [3, -4, 2.4]; // the direction from which a scene is seen first
const NEAREST = 0.75; // of the distance for the whole sphere: an orbit must not lose a box that is flat from this side

export type ViewCamera = PerspectiveCamera | OrthographicCamera;

export class CameraRig {
  private readonly perspective = new PerspectiveCamera(FIELD_OF_VIEW);
  private readonly orthographic = new OrthographicCamera();
  private aspect = 1;
  private up: UpAxis = 'z';
  camera: ViewCamera = this.perspective;
  controls: OrbitControls;

  constructor(private readonly element: HTMLElement, private readonly onChange: () => void) {
    this.controls = this.upright();
  }

  /** Turns the view so that this axis points up. A new axis is seen from the first direction again. */
  setUp(up: UpAxis): void {
    if (up === this.up) return;
    this.up = up;
    this.controls.dispose();
    this.controls = this.upright();
    this.onChange();
  }

  /** Cameras with the axis up, and controls for them: OrbitControls takes the axis only when it is made. */
  private upright(): OrbitControls {
    for (const camera of [this.perspective, this.orthographic]) {
      camera.up.set(...uprightDirection([0, 0, 1], this.up));
      camera.position.set(...uprightDirection(FROM, this.up));
    }
    const controls = new OrbitControls(this.camera, this.element);
    controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.ROTATE, RIGHT: MOUSE.PAN };
    controls.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
    controls.zoomToCursor = true;
    controls.update();
    controls.addEventListener('change', this.onChange);
    return controls;
  }

  get target(): Vector3 {
    return this.controls.target;
  }

  /** The camera as others may follow it. */
  pose(): CameraPose {
    const { camera, perspective, orthographic } = this;
    const [position, target, up] = [camera.position, this.target, camera.up].map((v) => v.toArray());
    const projection =
      camera === perspective ? { fovY: perspective.fov } : { height: (2 * orthographic.top) / orthographic.zoom };
    return { position, target, up, projection };
  }

  /** Shows what somebody else sees, through this window's own lens and with its own axis up. */
  show({ target, from, height }: Sight): void {
    const { camera } = this;
    const heightPerDistance = 2 * Math.tan((this.perspective.fov * Math.PI) / 360);
    const distance = camera === this.perspective ? height / heightPerDistance : camera.position.distanceTo(this.target);
    camera.zoom = camera === this.perspective ? 1 : (distance * heightPerDistance) / height;
    this.target.set(...target);
    camera.position.set(...add(target, scale(from, distance)));
    this.setLens();
    this.controls.update();
    this.onChange();
  }

  resize(width: number, height: number): void {
    this.aspect = width / Math.max(height, 1);
    this.setLens();
  }

  setOrthographic(on: boolean): void {
    const camera = on ? this.orthographic : this.perspective;
    if (camera === this.camera) return;
    camera.position.copy(this.camera.position);
    camera.quaternion.copy(this.camera.quaternion);
    // Zooming changes an orthographic camera's zoom, not its distance. The new camera must show the same part.
    if (on) camera.zoom = 1;
    else camera.position.sub(this.target).divideScalar(this.orthographic.zoom).add(this.target);
    this.camera = camera;
    this.controls.object = camera;
    this.setLens();
    this.controls.update();
    this.onChange();
  }

  /** Shows all of a box, from the camera's present direction. */
  frame(box: Box3): void {
    if (box.isEmpty()) return;
    const sphere = box.getBoundingSphere(new Sphere());
    const away = this.camera.position.clone().sub(this.target).normalize();
    const wholeSphere = Math.max(sphere.radius, 1e-9) / Math.sin((FIELD_OF_VIEW * Math.PI) / 360);
    const distance = Math.max(this.distanceToSee(box, sphere.center), NEAREST * MARGIN * wholeSphere);
    this.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(away, distance);
    this.camera.zoom = 1;
    this.setLens();
    this.controls.update();
    this.onChange();
  }

  /** Looks from a side of the scene, given for z up and its front towards -y. */
  lookFromSide(side: Vec3): void {
    this.lookFrom(uprightDirection(side, this.up));
  }

  /** Looks from the direction in the world that `from` points to, at the same distance. */
  lookFrom(from: Vec3): void {
    const distance = this.camera.position.distanceTo(this.target);
    // From straight above, the orbit needs a hint which way is up on the screen.
    const isAside = new Vector3(...from).dot(this.camera.up) === 0;
    const hint = new Vector3(...uprightDirection([0, isAside ? 0 : -1e-4, 0], this.up));
    const tilted = new Vector3(...from).add(hint).normalize();
    this.camera.position.copy(this.target).addScaledVector(tilted, distance);
    this.controls.update();
    this.onChange();
  }

  /** Right, up and towards the viewer. */
  basis(): Basis {
    this.camera.updateMatrixWorld();
    const e = this.camera.matrixWorld.elements;
    return WORLD_BASIS.map((_, i) => [e[4 * i], e[4 * i + 1], e[4 * i + 2]] as Vec3) as unknown as Basis;
  }

  /** Fits the depth range to `box`, also if the camera is inside it. */
  updateDepthRange(box: Box3): void {
    const sphere = box.getBoundingSphere(new Sphere());
    const distance = this.camera.position.distanceTo(sphere.center);
    const reach = Math.max(sphere.radius, 1e-6) * 2;
    this.camera.far = distance + reach;
    this.camera.near =
      this.camera === this.perspective ? Math.max(distance - reach, this.camera.far / 2000) : distance - 4 * reach;
    this.camera.updateProjectionMatrix();
  }

  /** The distance from `center`, along the line of sight, from which all corners of a box are seen. */
  private distanceToSee(box: Box3, center: Vector3): number {
    const [right, up, back] = this.basis().map((axis) => new Vector3(...axis));
    const upward = Math.tan((FIELD_OF_VIEW * Math.PI) / 360) / Math.min(this.aspect, 1);
    const sideways = upward * this.aspect;
    let distance = 0;
    for (let i = 0; i < 8; ++i) {
      const pick = (bit: number): Vector3 => (i & bit ? box.max : box.min);
      const corner = new Vector3(pick(1).x, pick(2).y, pick(4).z).sub(center);
      const across = Math.max(Math.abs(corner.dot(right)) / sideways, Math.abs(corner.dot(up)) / upward);
      distance = Math.max(distance, MARGIN * across + corner.dot(back));
    }
    return distance;
  }

  private setLens(): void {
    const portrait = Math.min(this.aspect, 1);
    this.perspective.aspect = this.aspect;
    const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    this.perspective.fov = (2 * Math.atan(half / portrait) * 180) / Math.PI;
    const height = (this.camera.position.distanceTo(this.target) * half) / portrait;
    this.orthographic.top = height;
    this.orthographic.bottom = -height;
    this.orthographic.right = height * this.aspect;
    this.orthographic.left = -height * this.aspect;
    this.perspective.updateProjectionMatrix();
    this.orthographic.updateProjectionMatrix();
  }
}

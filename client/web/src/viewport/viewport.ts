// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The canvas: a renderer, the scene and its cameras. A frame is drawn only when something has changed, and waits while
// the GPU is busy with earlier frames. While something moves it is drawn coarsely if frames take long.
import { Box3, Color, Scene, Vector3, WebGLRenderer } from 'three';
import { snapStep, type TransformView } from '../edit/transform_session';
import type { Basis, Vec3 } from '../lattice/vec';
import { refusalOf } from '../patches/gpu/evaluation_program';
import { Signal } from '../state/signal';
import { antialiasing } from './antialiasing';
import { CameraRig } from './camera_rig';
import { FrameQueue } from './frame_queue';
import { FINEST, pixelRatioOf, type Coarsened } from './motion';
import { jacobianAt, pixelsPerUnit, project, projectAll, rayAt, type Ray, type ScreenSize } from './projection';
import { Refinement } from './refinement';
import { Supersampling } from './supersampling';

const MAX_PIXEL_RATIO = 2; // a higher ratio looks no better, and costs a laptop's GPU much more

export class Viewport {
  readonly scene = new Scene();
  readonly renderer: WebGLRenderer;
  readonly rig: CameraRig;
  readonly size: ScreenSize = { width: 1, height: 1 };
  /** The box that the depth range must hold. */
  readonly content = new Box3(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));
  private readonly drawing = new Signal();
  /** Calls a listener before each frame that is drawn, and before those of onFrame. The function returned removes it. */
  readonly onDrawing = this.drawing.on;
  private readonly frame = new Signal();
  private readonly drawn = new Signal<[seen: Promise<void>]>();
  /** Calls a listener before each frame, and each time that a frame must wait. The function returned removes it. */
  readonly onFrame = this.frame.on;
  /** Calls a listener after each frame; `seen` resolves once its pixels are there. The function returned removes it. */
  readonly onDrawn = this.drawn.on;
  private readonly frames: FrameQueue;
  private readonly refinement = new Refinement(() => this.tickSoon());
  private readonly supersampling: Supersampling | undefined;
  private plan = FINEST; // of the last frame
  /** The surface that is drawn with fewer triangles while something moves. */
  coarsened: Coarsened | undefined;
  private isWanted = false;
  private pending = 0;

  constructor(readonly element: HTMLElement) {
    const smoothed = antialiasing();
    this.renderer = new WebGLRenderer({ antialias: smoothed === 'every frame', powerPreference: 'high-performance' });
    if (smoothed === 'at rest') this.supersampling = new Supersampling(this.renderer);
    this.frames = new FrameQueue(this.gl);
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute('aria-label', 'The deformed surface and its lattice. Press ? for the keys.');
    element.append(canvas);
    this.rig = new CameraRig(canvas, () => this.moved());
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
  }

  get canvas(): HTMLCanvasElement {
    return this.renderer.domElement;
  }

  /** The context of the renderer, which sets its state anew after resetState(). */
  get gl(): WebGL2RenderingContext {
    return this.renderer.getContext() as WebGL2RenderingContext;
  }

  /** Whether the GPU can evaluate patches. */
  get evaluatesPatches(): boolean {
    return refusalOf(this.gl) === undefined;
  }

  /** The height of the picture at rest, in its own pixels. */
  get pictureHeight(): number {
    return this.size.height * this.pixelRatio;
  }

  /** Whether the picture shows all changes in full detail. Its edges may still become smoother. */
  get isFine(): boolean {
    return !this.isWanted && !this.isPlanOld && this.plan === FINEST;
  }

  /** Whether the picture is fine and its edges are smooth. */
  get isSmooth(): boolean {
    return this.isFine && (this.supersampling?.isComplete ?? true);
  }

  /** Requests a frame. Several requests give one frame. */
  invalidate(): void {
    this.isWanted = true;
    this.refinement.changed();
    this.tickSoon();
  }

  /** Requests a frame, since something moves: it is drawn coarsely if frames take long, and finely soon after the motion. */
  moved(): void {
    this.isWanted = true;
    this.refinement.moved();
    this.tickSoon();
  }

  setBackground(colour: string): void {
    this.scene.background = new Color(colour);
    this.invalidate();
  }

  project(p: Vec3): Vec3 | undefined {
    this.updateCamera();
    return project(this.rig.camera, this.size, p);
  }

  projectAll(points: ArrayLike<number>): Float64Array {
    this.updateCamera();
    return projectAll(this.rig.camera, this.size, points);
  }

  /** A ball's disc in pixels; undefined behind the camera. */
  disc(center: Vec3, radius: number): { x: number; y: number; radius: number } | undefined {
    const at = this.project(center);
    return at && { x: at[0], y: at[1], radius: radius * pixelsPerUnit(this.rig.camera, this.size, center) };
  }

  ray(x: number, y: number): Ray {
    this.updateCamera();
    return rayAt(this.rig.camera, this.size, x, y);
  }

  /** The view, as a transform about `pivot` needs it. */
  transformView(pivot: Vec3, axes: Basis, secondAxes: Basis): TransformView {
    this.updateCamera();
    const [x, y] = project(this.rig.camera, this.size, pivot) ?? [this.size.width / 2, this.size.height / 2];
    return {
      basis: this.rig.basis(),
      jacobian: jacobianAt(this.rig.camera, this.size, pivot),
      pivot: [x, y],
      axes,
      secondAxes,
      snapStep: snapStep(pixelsPerUnit(this.rig.camera, this.size, pivot)),
    };
  }

  /** A pointer event's place in the canvas, in CSS pixels. */
  place(event: { clientX: number; clientY: number }): [number, number] {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.size.width = clientWidth;
    this.size.height = clientHeight;
    this.renderer.setSize(clientWidth, clientHeight);
    this.rig.resize(clientWidth, clientHeight);
    this.draw();
  }

  private updateCamera(): void {
    this.rig.camera.updateMatrixWorld();
  }

  private tickSoon(): void {
    this.pending ||= requestAnimationFrame(() => this.tick());
  }

  private get pixelRatio(): number {
    return Math.min(window.devicePixelRatio, MAX_PIXEL_RATIO);
  }

  private get isPlanOld(): boolean {
    return this.plan !== this.refinement.plan;
  }

  private get wantsSample(): boolean {
    return this.refinement.pace === 'settled' && this.supersampling?.isComplete === false;
  }

  /** Whether a frame would make the picture newer, finer or smoother. */
  private get isDue(): boolean {
    return this.isWanted || (this.refinement.pace !== 'moving' && this.isPlanOld) || this.wantsSample;
  }

  /** Listeners run even if drawing must wait, since the page must not be as slow as its pixels. */
  private tick(): void {
    this.pending = 0;
    this.frames.poll();
    if (this.isDue && !this.frames.isFull) this.draw();
    else if (this.isWanted) this.frame.emit();
    if (this.isDue || !this.frames.isEmpty) this.tickSoon();
  }

  private draw(): void {
    const isSample = this.wantsSample && this.isFine;
    this.isWanted = false;
    this.drawing.emit();
    this.takePlan();
    this.frame.emit();
    this.rig.updateDepthRange(this.content);
    if (isSample) this.drawSample();
    else this.drawFirst();
    const seen = this.frames.add();
    void this.measure(seen);
    this.drawn.emit(seen);
    this.tickSoon();
  }

  /** A frame without antialiasing. At rest, samples will follow it. */
  private drawFirst(): void {
    this.renderer.render(this.scene, this.rig.camera);
    this.supersampling?.restart(this.isFine && this.refinement.pace !== 'moving');
  }

  /** Nothing has changed since the frame before, which was fine. */
  private drawSample(): void {
    this.coarsened?.setDetail(this.plan.detail, 'kept');
    this.supersampling!.draw(this.scene, this.rig.camera);
    this.coarsened?.setDetail(this.plan.detail, 'new');
  }

  private takePlan(): void {
    const { plan } = this.refinement;
    this.plan = plan;
    this.coarsened?.setDetail(plan.detail, plan === FINEST ? 'new' : 'none');
    const ratio = this.pixelRatio * pixelRatioOf(plan);
    if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio);
  }

  private async measure(seen: Promise<void>): Promise<void> {
    const { plan, size } = this;
    await seen;
    const pixels = size.width * size.height * this.pixelRatio ** 2;
    this.refinement.measured(plan, this.frames.lastMs, this.coarsened?.triangles ?? [0], pixels);
  }
}

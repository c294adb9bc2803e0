// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** A page around one session, for tests in a browser to steer: no controls, a canvas and `window.harness`. */
import { Color, DataArrayTexture, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from 'three';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import { IndexedSceneStore } from '@src/session/indexed_scene_store';
import type { SurfacePoint } from '@src/session/lattice_edit';
import { openSession } from '@src/session/open_session';
import type { Presence, SceneSession, UpdateInfo, ViewRequest } from '@src/session/scene_session';
import type { SurfaceMesh } from '@src/surface/surface_mesh';
import { randomId } from '@src/wire/ids';
import { LatticedServer } from '@src/wire/latticed_server';
import { uploadMesh } from '@src/wire/upload';

const MOST_POINTS = 4096;  // of one call to EvaluatePoints

/**
 * Some points of a patch's pattern, by their places in it, and their weights of the patch's corners. Row 0 runs from corner
 * 0 to corner 1, the next one back; the last row is corner 2.
 */
function patternPoints(segments: number): { place: number; weights: number[] }[] {
  const [second, third] = [segments + 1, 2 * segments + 1];
  const corners = [0, segments, (segments + 1) * (segments + 2) / 2 - 1].map((place, corner) =>
    ({ place, weights: [0, 1, 2].map((k) => Number(k === corner)) }));
  const inner = (place: number, along: number, across: number): { place: number; weights: number[] } =>
    ({ place, weights: [segments - along - across, along, across].map((count) => count / segments) });
  return segments < 4 ? corners : [...corners, inner(second + 1, segments - 2, 1), inner(third + 1, 1, 2)];
}

class Harness {
  readonly server = new LatticedServer(location.origin);
  readonly store = IndexedSceneStore.ofPage();
  readonly updates: UpdateInfo[] = [];
  /** Updates since the session was opened that moved something. */
  received = 0;
  readonly refused: string[] = [];
  readonly statuses: string[] = [];
  others: ReadonlyMap<string, Presence> = new Map();
  session!: SceneSession;
  private readonly renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(40, 4 / 3);
  private waiting: (() => void)[] = [];

  constructor() {
    this.renderer.setSize(480, 360);
    this.scene.background = new Color(0x20242b);
    document.body.append(this.renderer.domElement);
  }

  get surface(): SurfaceMesh {
    return this.session.surface as SurfaceMesh;
  }

  /** Uploads an OBJ file and makes a scene of it; returns its id. */
  async makeScene(obj: string, size: number): Promise<string> {
    const mesh = await uploadMesh(this.server, { name: 'test.obj', format: MeshFormat.OBJ }, new Blob([obj]));
    const sceneId = randomId();
    const axes = { u: size, v: size, w: size };
    await this.server.scenes.createScene({ sceneId, mesh: mesh.id, lattices: [{ source: { case: 'fit', value: { size: axes } } }] });
    return sceneId;
  }

  async open(sceneId: string, view?: ViewRequest): Promise<void> {
    this.session = await openSession(this.server, sceneId, {
      ...(view && { view }),
      onStatus: ({ state }) => {
        this.statuses.push(state);
        if (state === 'restored') this.updates.length = 0;  // revisions begin anew
      } });
    this.session.on('update', (info) => {
      this.updates.push(info);
      if (info.patchesSent > 0) ++this.received;
      for (const wake of this.waiting.splice(0)) wake();
    });
    this.session.on('refused', (text) => this.refused.push(text));
    this.session.on('presence', (others) => (this.others = others));
    this.scene.add(this.session.surface.object);
    await this.until(() => this.session.surface.patchCount > 0);
    this.frame();
  }

  /** Waits for updates until something holds. */
  async until(holds: () => boolean): Promise<void> {
    while (!holds()) await new Promise<void>((resolve) => this.waiting.push(resolve));
  }

  /** Waits for the update that holds every edit so far, which the server has when it has answered it. */
  async settled(): Promise<void> {
    const { queue } = (this.session as unknown as { sync: { queue: { readonly unanswered: number } } }).sync;
    while (queue.unanswered > 0) await new Promise((resolve) => setTimeout(resolve, 5));
    const { revision } = await this.server.scenes.getScene({ scene: this.session.sceneId });
    await this.until(() => (this.updates.at(-1)?.revision ?? -1) >= Number(revision) && this.updates.at(-1)!.fullDetail);
  }

  /** Shows the surface with so many segments a patch edge. */
  async setSegments(segments: number): Promise<void> {
    this.session.setView({ segments });
    await this.until(() => this.surface.drawnLayout?.segments === segments);
  }

  /** Looks at the surface from the front, upper left. */
  frame(): void {
    const { bounds } = this.session.surface;
    const size = bounds.getSize(new Vector3()).length();
    const middle = bounds.getCenter(new Vector3());
    this.camera.position.copy(middle).add(new Vector3(-0.35, 0.4, 1).multiplyScalar(1.2 * size));
    this.camera.near = 0.05 * size;
    this.camera.far = 5 * size;
    this.camera.lookAt(middle);
    this.camera.updateProjectionMatrix();
  }

  /** Draws a frame and waits until it is there: only reading it back waits, finish() returns at once. */
  draw(): void {
    this.renderer.render(this.scene, this.camera);
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  /** Fraction of pixels that show the surface, and the mean colour of those, 0 to 255. */
  pixels(): { covered: number; mean: number[] } {
    this.draw();
    const gl = this.renderer.getContext();
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const data = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
    const sum = [0, 0, 0];
    let covered = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i] === data[0] && data[i + 1] === data[1] && data[i + 2] === data[2]) continue;  // a corner is empty
      ++covered;
      for (let c = 0; c < 3; ++c) sum[c] += data[i + c];
    }
    return { covered: covered / (width * height), mean: sum.map((total) => total / Math.max(covered, 1)) };
  }

  /** Draws with a red layer and a green one: faces up to `middle`, three corners each, are red. */
  paint(faces: number, middle: number): void {
    const texture = new DataArrayTexture(Uint8Array.of(255, 0, 0, 255, 0, 255, 0, 255), 1, 1, 2);
    texture.needsUpdate = true;
    const corners = Float32Array.from({ length: 9 * faces }, (_, i) => (i % 3 < 2 ? 0.5 : i < 9 * middle ? 0 : 1));
    this.surface.setLook({ colouring: 'texture' });
    this.surface.setTexture(texture, corners);
  }

  get geometries(): number {
    return this.renderer.info.memory.geometries;
  }

  /**
   * Largest distance of received points from where EvaluatePoints says they are, in steps of the grid or, of floats, in
   * millionths of the size: corners of every `stride`th patch, and points of two of its inner rows.
   */
  async worstPoint(topologyId: string, stride: number): Promise<number> {
    const { scenes } = this.server;
    const scene = this.session.sceneId;
    const points: { face: number; corners: number[]; barycentrics: number[] }[] = [];
    const places: number[] = [];
    const layout = this.surface.drawnLayout!;
    for await (const part of scenes.getTopology({ scene, topologyId })) {
      for (let patch = 0; patch < part.faces.length; patch += stride) {
        const number = patch + Number(part.firstPatch);
        patternPoints(layout.segments).forEach(({ place, weights }) => {
          const barycentrics = [0, 1, 2].map((k) =>
            weights.reduce((sum, weight, corner) => sum + weight * part.barycentrics[9 * patch + 3 * corner + k], 0));
          points.push({ face: part.faces[patch], corners: part.corners.slice(3 * patch, 3 * patch + 3), barycentrics });
          places.push(number * layout.pointsPerPatch + place);
        });
      }
    }
    const positions: number[] = [];
    for (let first = 0; first < points.length; first += MOST_POINTS) {
      const value = { points: points.slice(first, first + MOST_POINTS) };
      positions.push(...(await scenes.evaluatePoints({ scene, points: { case: 'surfacePoints', value } })).positions);
    }
    const unit = this.surface.drawnStep === 1 ? this.surface.bounds.getSize(new Vector3()).length() / 1e6 : this.surface.drawnStep!;
    return Math.max(...places.map((place, i) =>
      Math.hypot(...this.surface.positionOf(place).map((value, axis) => value - positions[3 * i + axis])) / unit));
  }

  /** Where surface points are, by the definition in double. */
  async evaluate(points: readonly SurfacePoint[]): Promise<number[]> {
    const surfacePoints = points.map(({ face, corners, barycentrics }) =>
      ({ face, corners: [...corners], barycentrics: [...barycentrics] }));
    const { positions } = await this.server.scenes.evaluatePoints({
      scene: this.session.sceneId, points: { case: 'surfacePoints', value: { points: surfacePoints } } });
    return positions;
  }

  /** Drags one control point in a circle: `steps` updates of a gesture, each after the update of the one before. */
  async drag(index: number, steps: number, radius: number): Promise<void> {
    const gesture = this.session.gesture();
    for (let step = 0; step < steps; ++step) {
      const angle = (2 * Math.PI * step) / 60;
      this.updates.length = 0;
      gesture.update({ kind: 'move', indices: Uint32Array.of(index),
        offset: [radius * Math.cos(angle), radius * Math.sin(angle), radius * Math.sin(2 * angle)] });
      await this.until(() => this.updates.some(({ msFromEdit }) => msFromEdit !== undefined));
      if (step % 50 === 0) this.draw();  // without a graphics card a frame takes longer than all the rest
    }
    gesture.commit();
  }
}

declare global {
  interface Window {
    harness: Harness;
  }
}

window.harness = new Harness();

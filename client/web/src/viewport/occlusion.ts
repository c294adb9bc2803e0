// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The control points that the surface hides, for selection of visible points. The surface's depth is drawn into a
// texture. Then each control point is one pixel of a second target, which tells if that depth is in front of it.
import {
  BufferAttribute,
  BufferGeometry,
  DepthTexture,
  FloatType,
  Points,
  Scene,
  ShaderMaterial,
  WebGLRenderTarget,
  type Object3D,
} from 'three';
import type { Viewport } from './viewport';

const WIDTH = 256; // of the second target; 128 rows hold the 32,768 points that a lattice may have

const VERTEX = /* glsl */ `
attribute float number;
uniform sampler2D depth;
uniform float rows;
varying float vVisible;
void main() {
  vec4 clip = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  vec3 ndc = clip.xyz / clip.w;
  float front = texture2D(depth, ndc.xy * 0.5 + 0.5).r;
  vVisible = clip.w > 0.0 && ndc.z * 0.5 + 0.5 <= front + 2e-4 ? 1.0 : 0.0;
  vec2 cell = vec2(mod(number, ${WIDTH}.0), floor(number / ${WIDTH}.0)) + 0.5;
  gl_Position = vec4(cell / vec2(${WIDTH}.0, rows) * 2.0 - 1.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}`;

const FRAGMENT = /* glsl */ `
varying float vVisible;
void main() { gl_FragColor = vec4(vVisible); }`;

export class Occlusion {
  private readonly scene = new Scene();
  private readonly depth = new WebGLRenderTarget(1, 1, { depthTexture: new DepthTexture(1, 1, FloatType) });
  private readonly material = new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: { depth: { value: this.depth.depthTexture }, rows: { value: 1 } },
    depthTest: false,
    depthWrite: false,
  });

  constructor(private readonly viewport: Viewport) {}

  /** One byte per point, 0 if `surface` hides the point from the camera. */
  visiblePoints(points: Float64Array, surface: Object3D): Uint8Array {
    const count = points.length / 3;
    const rows = Math.ceil(count / WIDTH);
    const answers = new WebGLRenderTarget(WIDTH, rows);
    const object = this.pointsObject(points);
    this.material.uniforms['rows'].value = rows;
    this.drawDepth(surface);
    this.drawAnswers(object, answers);

    const pixels = new Uint8Array(4 * WIDTH * rows);
    this.viewport.renderer.readRenderTargetPixels(answers, 0, 0, WIDTH, rows, pixels);
    answers.dispose();
    object.geometry.dispose();
    return Uint8Array.from({ length: count }, (_, i) => (pixels[4 * i] > 127 ? 1 : 0));
  }

  dispose(): void {
    this.depth.dispose();
    this.material.dispose();
  }

  private pointsObject(points: Float64Array): Points {
    const origin = points.subarray(0, 3);
    const geometry = new BufferGeometry();
    const relative = Float32Array.from(points, (x, i) => x - origin[i % 3]);
    geometry.setAttribute('position', new BufferAttribute(relative, 3));
    geometry.setAttribute('number', new BufferAttribute(Float32Array.from({ length: points.length / 3 }, (_, i) => i), 1));
    const object = new Points(geometry, this.material);
    object.position.set(origin[0], origin[1], origin[2]);
    object.frustumCulled = false;
    return object;
  }

  /** Moves the surface into a scene of its own meanwhile, since nothing else may hide a point. */
  private drawDepth(surface: Object3D): void {
    const { renderer, rig, size } = this.viewport;
    const parent = surface.parent;
    this.depth.setSize(size.width, size.height);
    this.scene.add(surface);
    renderer.setRenderTarget(this.depth);
    renderer.clear();
    renderer.render(this.scene, rig.camera);
    renderer.setRenderTarget(null);
    parent?.add(surface);
  }

  private drawAnswers(object: Points, target: WebGLRenderTarget): void {
    const { renderer, rig } = this.viewport;
    const scene = new Scene().add(object);
    renderer.setRenderTarget(target);
    renderer.render(scene, rig.camera);
    renderer.setRenderTarget(null);
  }
}

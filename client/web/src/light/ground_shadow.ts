// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A soft shadow on the ground under the surface, darker where the surface is near: a picture of heights over the ground,
// drawn from below, then blurred. It is drawn again when the scene has changed, not when the camera moves.
import {
  DoubleSide, Mesh, OrthographicCamera, PlaneGeometry, ShaderMaterial, Vector2, Vector3, WebGLRenderTarget, type Box3, type Camera, type Material,
  type WebGLRenderer,
} from 'three';
import { FullScreenQuad } from 'three/examples/jsm/postprocessing/Pass.js';
import { FULL_SCREEN_VERTEX } from './full_screen';

const PIXELS = 128; // of the picture, along each side
const MARGIN = 1.7; // of the larger side of the ground under the surface: the shadow fades inside
const GAP = 0.01; // of the same, between the surface and the ground

const FROM_BELOW = {
  vertexShader: /* glsl */ `
    out float height;
    uniform float fade;
    void main() {
      vec4 place = modelViewMatrix * vec4(position, 1.0);
      height = -place.z / fade;
      gl_Position = projectionMatrix * place;
    }`,
  fragmentShader: /* glsl */ `
    in float height;
    void main() {
      gl_FragColor = vec4(exp(-height));
    }`,
};

/** Weights of the picture's pixels beside one. A place between two of them reads both in one look, by their shares. */
const SHARES = [0, 1, 2, 3, 4, 5, 6].map((i) => Math.exp(-i * i / 14));
const LOOKS = [1, 3, 5].map((i) => ({ weight: SHARES[i] + SHARES[i + 1], at: i + SHARES[i + 1] / (SHARES[i] + SHARES[i + 1]) }));
const WHOLE = LOOKS.reduce((sum, { weight }) => sum + 2 * weight, SHARES[0]);

const BLUR = {
  vertexShader: FULL_SCREEN_VERTEX,
  fragmentShader: /* glsl */ `
    uniform sampler2D picture;
    uniform vec2 along;
    in vec2 place;
    void main() {
      float sum = ${SHARES[0] / WHOLE} * texture(picture, place).r;
      ${LOOKS.map(({ weight, at }) => `
        sum += ${weight / WHOLE} * texture(picture, place + ${at} * along).r;
        sum += ${weight / WHOLE} * texture(picture, place - ${at} * along).r;`).join('')}
      gl_FragColor = vec4(sum);
    }`,
};

const GROUND = {
  vertexShader: /* glsl */ `
    out vec2 place;
    void main() {
      place = vec2(uv.x, 1.0 - uv.y);
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    }`,
  fragmentShader: /* glsl */ `
    uniform sampler2D picture;
    uniform float strength;
    in vec2 place;
    void main() {
      gl_FragColor = vec4(0.0, 0.0, 0.0, strength * texture(picture, place).r);
    }`,
};

/** Draws the surface alone with a material. */
export type DrawSurface = (renderer: WebGLRenderer, camera: Camera, material: Material) => void;

export class GroundShadow {
  private readonly up = new Vector3(0, 0, 1);
  private readonly pictures = [0, 1].map(() => new WebGLRenderTarget(PIXELS, PIXELS)) as [WebGLRenderTarget, WebGLRenderTarget];
  private readonly camera = new OrthographicCamera();
  private readonly fromBelow = new ShaderMaterial({ ...FROM_BELOW, uniforms: { fade: { value: 1 } }, side: DoubleSide });
  private readonly blur = new ShaderMaterial({
    ...BLUR, uniforms: { picture: { value: null }, along: { value: new Vector2() } }, depthTest: false, depthWrite: false,
  });
  private readonly quad = new FullScreenQuad(this.blur);
  private readonly ground = new ShaderMaterial({
    ...GROUND, uniforms: { picture: { value: this.pictures[0].texture }, strength: { value: 0 } }, transparent: true, depthWrite: false,
  });
  readonly object = new Mesh(new PlaneGeometry(1, 1), this.ground);
  /** How dark it is, 0 to 1. */
  strength = 0.5;

  constructor() {
    this.object.onBeforeRender = (_, __, camera) => this.fadeFromAbove(camera);
    this.object.matrixAutoUpdate = false;
  }

  /** Follows the surface, whose ground is across `up`. */
  update(renderer: WebGLRenderer, bounds: Box3, up: readonly [number, number, number], draw: DrawSurface): void {
    if (bounds.isEmpty()) return;
    const size = this.place(bounds, up);
    this.fromBelow.uniforms['fade'].value = 0.35 * size;
    const target = renderer.getRenderTarget();
    renderer.setRenderTarget(this.pictures[0]);
    draw(renderer, this.camera, this.fromBelow);
    this.blurAlong(renderer, 0, 1);
    this.blurAlong(renderer, 1, 0);
    renderer.setRenderTarget(target);
  }

  dispose(): void {
    for (const owned of [...this.pictures, this.fromBelow, this.blur, this.ground, this.quad, this.object.geometry]) owned.dispose();
  }

  /** Puts the ground below the bounds, and the camera below the ground. Returns the larger side of the bounds on the ground. */
  private place(bounds: Box3, up: readonly [number, number, number]): number {
    this.up.set(...up);
    const right = new Vector3(up[1], up[2], up[0]); // the next axis; up is one of the axes
    const front = new Vector3().crossVectors(this.up, right);
    const [extent, middle] = [bounds.getSize(new Vector3()), bounds.getCenter(new Vector3())];
    const size = Math.max(extent.dot(right), Math.abs(extent.dot(front)), 1e-9);
    const height = extent.dot(this.up);
    middle.addScaledVector(this.up, -height / 2 - GAP * size);
    const side = MARGIN * size;
    this.object.matrix.makeBasis(right, front, this.up).scale(new Vector3(side, side, 1)).setPosition(middle);
    this.object.matrixWorldNeedsUpdate = true;
    Object.assign(this.camera, { left: -side / 2, right: side / 2, bottom: -side / 2, top: side / 2, near: 0, far: height + 2 * GAP * size });
    this.camera.position.copy(middle);
    this.camera.up.copy(front).negate();
    this.camera.lookAt(middle.clone().add(this.up));
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    return size;
  }

  private blurAlong(renderer: WebGLRenderer, from: 0 | 1, to: 0 | 1): void {
    this.blur.uniforms['picture'].value = this.pictures[from].texture;
    this.blur.uniforms['along'].value.set(Number(from === 0), Number(from === 1)).divideScalar(PIXELS);
    renderer.setRenderTarget(this.pictures[to]);
    this.quad.render(renderer);
  }

  /** Seen from straight above it would only dirty the outline. */
  private fadeFromAbove(camera: Camera): void {
    const steep = Math.abs(camera.getWorldDirection(new Vector3()).dot(this.up));
    this.ground.uniforms['strength'].value = this.strength * Math.min(Math.max((0.95 - steep) / 0.15, 0), 1);
  }
}

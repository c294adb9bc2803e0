// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Antialiasing of a view at rest: the average of frames that are shifted by parts of a pixel. Each is a frame of its own, so
// an edit between them need not wait for all.
import { FramebufferTexture, ShaderMaterial, Vector2, type Scene, type WebGLRenderer } from 'three';
import { FullScreenQuad } from 'three/examples/jsm/postprocessing/Pass.js';
import { FULL_SCREEN_VERTEX } from '../light/full_screen';
import type { ViewCamera } from './camera_rig';

/** Where the samples lie in a pixel: on a turned square. The first one is the frame without antialiasing. */
const SAMPLES = [[0, 0], [0.375, 0.125], [-0.125, 0.375], [-0.375, -0.125], [0.125, -0.375]] as const;

const FRAGMENT = /* glsl */ `
  uniform sampler2D samples[${SAMPLES.length}];
  uniform int count;
  in vec2 place;
  void main() {
    vec4 sum = texture(samples[0], place);
    if (count > 1) sum += texture(samples[1], place);
    if (count > 2) sum += texture(samples[2], place);
    if (count > 3) sum += texture(samples[3], place);
    if (count > 4) sum += texture(samples[4], place);
    gl_FragColor = vec4(sum.rgb / float(count), 1.0);
  }`;

export class Supersampling {
  private readonly size = new Vector2();
  private textures: FramebufferTexture[] = [];
  private readonly material = new ShaderMaterial({
    vertexShader: FULL_SCREEN_VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: { samples: { value: [] as FramebufferTexture[] }, count: { value: 0 } },
    depthTest: false,
    depthWrite: false,
  });
  private readonly quad = new FullScreenQuad(this.material);
  private count = 0;

  constructor(private readonly renderer: WebGLRenderer) {}

  /** Whether all samples are drawn. */
  get isComplete(): boolean {
    return this.count === SAMPLES.length;
  }

  /** The picture has changed. `keeps`: it has just been drawn, and is the first sample. */
  restart(keeps: boolean): void {
    this.count = 0;
    if (keeps) this.keep();
  }

  /** Draws another sample, and shows the average of those so far. */
  draw(scene: Scene, camera: ViewCamera): void {
    const { x, y } = this.renderer.getDrawingBufferSize(this.size);
    const [right, up] = SAMPLES[this.count];
    camera.setViewOffset(x, y, right, up, x, y);
    this.renderer.render(scene, camera);
    camera.clearViewOffset();
    this.keep();
    if (this.count === 1) return;
    this.material.uniforms['count'].value = this.count;
    this.quad.render(this.renderer);
  }

  private keep(): void {
    const { x, y } = this.renderer.getDrawingBufferSize(this.size);
    this.fit(x, y);
    this.renderer.copyFramebufferToTexture(this.textures[this.count]);
    ++this.count;
  }

  private fit(width: number, height: number): void {
    const first = this.textures.at(0)?.image as { width: number; height: number } | undefined;
    if (first?.width === width && first.height === height) return;
    for (const texture of this.textures) texture.dispose();
    this.textures = SAMPLES.map(() => new FramebufferTexture(width, height));
    this.material.uniforms['samples'].value = this.textures;
    this.count = 0;
  }
}

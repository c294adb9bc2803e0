// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Cavity shading: darker in hollows, lighter on ridges, by the mean curvature in the picture. Normals are compared over
// a distance, not between neighbouring points of the stream, whose rounding would show as grain.
import {
  HalfFloatType, LinearFilter, NearestFilter, ShaderMaterial, Vector2, WebGLRenderTarget, type Camera, type Texture,
  type WebGLRenderer,
} from 'three';
import { FullScreenQuad } from 'three/examples/jsm/postprocessing/Pass.js';
import { FULL_SCREEN_VERTEX } from './full_screen';

const COARSER = 2; // pixels of the view, along each side, for one of these pictures

/** `normals` holds x y of the normal in the view and the distance along the line of sight, in sizes; 0 where nothing is. */
const FRAGMENT = /* glsl */ `
  uniform sampler2D normals;
  uniform vec2 texel;
  uniform float zoom;
  uniform float isPerspective;
  uniform float size;
  in vec2 place;

  const float RADIUS = 0.02;        // of the surface's size
  const float FARTHEST = 0.04;      // of the view's height
  const float SHARP = 4.0;          // the curvature, times the size, that has half of the effect

  void main() {
    vec3 here = texture(normals, place).xyz;
    float distance = mix(1.0 / size, here.z, isPerspective);
    float reach = clamp(RADIUS * zoom / distance, texel.y, FARTHEST);
    float radius = reach * distance / zoom;  // in sizes, like the distance
    float bend = 0.0;
    float weights = 1e-3;
    for (int i = 0; i < 8; ++i) {
      vec2 direction = vec2(cos(float(i) * 0.785398 + 0.4), sin(float(i) * 0.785398 + 0.4));
      vec3 there = texture(normals, place + direction * reach * vec2(texel.x / texel.y, 1.0)).xyz;
      float weight = there.z > 0.0 && abs(there.z - here.z) < 4.0 * radius ? 1.0 : 0.0;
      bend += weight * dot(there.xy - here.xy, direction);
      weights += weight;
    }
    float curvature = here.z > 0.0 ? bend / (radius * weights) : 0.0;
    gl_FragColor = vec4(0.5 + 0.5 * curvature / (abs(curvature) + SHARP));
  }`;

export class Cavity {
  private readonly normals = new WebGLRenderTarget(1, 1, { type: HalfFloatType, minFilter: NearestFilter, magFilter: NearestFilter });
  private readonly hollows = new WebGLRenderTarget(1, 1, { depthBuffer: false, minFilter: LinearFilter, magFilter: LinearFilter });
  private readonly material = new ShaderMaterial({
    vertexShader: FULL_SCREEN_VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: {
      normals: { value: this.normals.texture }, texel: { value: new Vector2() }, zoom: { value: 1 }, isPerspective: { value: 1 },
      size: { value: 1 },
    },
    depthTest: false,
    depthWrite: false,
  });
  private readonly quad = new FullScreenQuad(this.material);
  private readonly drawn = new Vector2();

  /** The curvature over the view: 0 in the deepest hollow, 0.5 where it is flat, 1 on the sharpest ridge. */
  get texture(): Texture {
    return this.hollows.texture;
  }

  /**
   * Draws it for a surface of `size`. May be called within a frame: the frame's target stays.
   * @param drawNormals Draws normals and distances, like FRAGMENT reads them.
   */
  draw(renderer: WebGLRenderer, camera: Camera, size: number, drawNormals: () => void): void {
    const target = renderer.getRenderTarget();
    renderer.getDrawingBufferSize(this.drawn).divideScalar(COARSER).ceil();
    this.normals.setSize(this.drawn.x, this.drawn.y);
    this.hollows.setSize(this.drawn.x, this.drawn.y);
    const { texel, zoom, isPerspective, size: sizeOf } = this.material.uniforms;
    texel.value.set(1 / this.drawn.x, 1 / this.drawn.y);
    zoom.value = camera.projectionMatrix.elements[5] / 2;
    isPerspective.value = camera.projectionMatrix.elements[11] === 0 ? 0 : 1;
    sizeOf.value = size;
    renderer.setRenderTarget(this.normals);
    renderer.state.buffers.depth.setMask(true); // else it is not cleared
    drawNormals();
    renderer.setRenderTarget(this.hollows);
    this.quad.render(renderer);
    renderer.setRenderTarget(target);
  }

  dispose(): void {
    this.normals.dispose();
    this.hollows.dispose();
    this.material.dispose();
    this.quad.dispose();
  }
}

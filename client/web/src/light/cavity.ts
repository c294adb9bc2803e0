// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the shape itself does to the light, from the normals and distances in the picture: hollows are darker and ridges
// lighter, and what hides a part of the sky leaves less light.
import {
  DataTexture, HalfFloatType, LinearFilter, NearestFilter, ShaderMaterial, Vector2, Vector4, WebGLRenderTarget, type Box3, type Camera,
  type Texture, type WebGLRenderer,
} from 'three';
import { FullScreenQuad } from 'three/examples/jsm/postprocessing/Pass.js';
import { BLUR, HOLLOWS } from './cavity_shaders';
import { FULL_SCREEN_VERTEX } from './full_screen';
import { partSeen } from './part_seen';

const COARSER = 2; // pixels of the view, along each side, for one of these pictures
const MARGIN = 4; // pixels around the surface: the blur reads beyond it, and its picture is read between pixels

export class Cavity {
  private readonly normals = new WebGLRenderTarget(1, 1, { type: HalfFloatType, minFilter: NearestFilter, magFilter: NearestFilter });
  private readonly rough = new WebGLRenderTarget(
    1, 1, { type: HalfFloatType, depthBuffer: false, minFilter: NearestFilter, magFilter: NearestFilter });
  private readonly hollows = new WebGLRenderTarget(1, 1, { depthBuffer: false, minFilter: LinearFilter, magFilter: LinearFilter });
  private readonly texel = { value: new Vector2() };
  private readonly material = new ShaderMaterial({
    vertexShader: FULL_SCREEN_VERTEX,
    fragmentShader: HOLLOWS,
    uniforms: {
      normals: { value: this.normals.texture }, texel: this.texel, zoom: { value: 1 }, isPerspective: { value: 1 }, size: { value: 1 },
    },
    depthTest: false,
    depthWrite: false,
  });
  private readonly blur = new ShaderMaterial({
    vertexShader: FULL_SCREEN_VERTEX,
    fragmentShader: BLUR,
    uniforms: { picture: { value: this.rough.texture } },
    depthTest: false,
    depthWrite: false,
  });
  /** A texture without hollows and ridges. */
  readonly none = new DataTexture(new Uint8Array([128, 0, 0, 0]), 1, 1);
  private readonly quad = new FullScreenQuad(this.material);
  private readonly drawn = new Vector2();
  private readonly part = new Vector4();

  constructor() {
    this.rough.scissorTest = this.hollows.scissorTest = true;
    this.none.needsUpdate = true;
  }

  /**
   * Over the view, where the surface is: the curvature, 0 in the deepest hollow, 0.5 where it is flat, 1 on the sharpest ridge;
   * the share of the sky that is hidden.
   */
  get texture(): Texture {
    return this.hollows.texture;
  }

  /**
   * Draws it for a surface of `size` within `bounds` of the world, and no pixels far from it. May be called within a frame: the frame's target stays.
   * @param drawNormals Draws normals and distances, like HOLLOWS reads them.
   */
  draw(renderer: WebGLRenderer, camera: Camera, bounds: Box3, size: number, drawNormals: () => void): void {
    const target = renderer.getRenderTarget();
    renderer.getDrawingBufferSize(this.drawn).divideScalar(COARSER).ceil();
    for (const picture of [this.normals, this.rough, this.hollows]) picture.setSize(this.drawn.x, this.drawn.y);
    partSeen(camera, bounds, this.drawn, MARGIN, this.part);
    for (const picture of [this.rough, this.hollows]) picture.scissor.copy(this.part);
    const { zoom, isPerspective, size: sizeOf } = this.material.uniforms;
    this.texel.value.set(1 / this.drawn.x, 1 / this.drawn.y);
    zoom.value = camera.projectionMatrix.elements[5] / 2;
    isPerspective.value = camera.projectionMatrix.elements[11] === 0 ? 0 : 1;
    sizeOf.value = size;
    renderer.setRenderTarget(this.normals);
    renderer.state.buffers.depth.setMask(true); // else it is not cleared
    drawNormals();
    this.fill(renderer, this.rough, this.material);
    this.fill(renderer, this.hollows, this.blur);
    renderer.setRenderTarget(target);
  }

  dispose(): void {
    for (const owned of [this.normals, this.rough, this.hollows, this.material, this.blur, this.none, this.quad]) owned.dispose();
  }

  private fill(renderer: WebGLRenderer, target: WebGLRenderTarget, material: ShaderMaterial): void {
    this.quad.material = material;
    renderer.setRenderTarget(target);
    this.quad.render(renderer);
  }
}

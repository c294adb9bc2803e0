// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Discs with a diameter in pixels and a rim. A ring in another editor's colour marks a point that this editor has
// selected. Each material draws all points in one call.
import { GreaterDepth, LessEqualDepth, LineBasicMaterial, ShaderMaterial } from 'three';

/** Draws discs a little nearer than they are, so that a disc on the surface is not half inside it. */
const VERTEX = /* glsl */ `
attribute vec4 disc;   // colour, and diameter / 255
attribute vec4 ring;   // another editor's colour; alpha 0 where there is none
uniform float pixelRatio;
varying vec3 vColour;
varying vec4 vRing;
varying float vPixels;
void main() {
  vColour = disc.rgb;
  vRing = ring;
  float diameter = disc.a * 255.0 + (ring.a > 0.0 ? 7.0 : 0.0);
  vPixels = diameter * pixelRatio;
  gl_PointSize = vPixels;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_Position.z -= 0.0004 * gl_Position.w;
  if (disc.a == 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;

const FRAGMENT = /* glsl */ `
uniform vec3 rim;
uniform float opacity;
uniform float pixelRatio;
varying vec3 vColour;
varying vec4 vRing;
varying float vPixels;
void main() {
  float inside = vPixels * (0.5 - length(gl_PointCoord - 0.5));  // pixels from the outer edge
  if (inside < 0.0) discard;
  float edge = vRing.a > 0.0 ? 3.5 * pixelRatio : 0.0;
  vec3 colour = mix(rim, vColour, smoothstep(1.0, 2.0, (inside - edge) / pixelRatio));
  if (vRing.a > 0.0) colour = mix(vRing.rgb, colour, smoothstep(-0.5, 0.5, inside - edge + pixelRatio));
  gl_FragColor = vec4(colour, opacity * smoothstep(0.0, 1.0, inside));
  #include <colorspace_fragment>
}`;

/** `behind`: draws only the parts that the surface hides, faintly. */
export function discMaterial(behind: boolean): ShaderMaterial {
  return new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: { pixelRatio: { value: 1 }, rim: { value: null }, opacity: { value: behind ? 0.4 : 1 } },
    transparent: true,
    depthWrite: false,
    depthFunc: behind ? GreaterDepth : LessEqualDepth,
  });
}

export function lineMaterial(behind: boolean): LineBasicMaterial {
  return new LineBasicMaterial({
    vertexColors: true,
    transparent: true,
    opacity: behind ? 0.16 : 0.95,
    depthWrite: false,
    depthFunc: behind ? GreaterDepth : LessEqualDepth,
  });
}

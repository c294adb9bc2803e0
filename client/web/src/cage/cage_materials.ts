// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Discs with a diameter in pixels and a rim. A ring in another editor's colour marks a point that this editor has
// selected. Each material draws all points in one call.
import { Color, GreaterDepth, LessEqualDepth, ShaderMaterial } from 'three';

/** Draws a little nearer than it is, so that a disc or a line on the surface is not half inside it. */
const NEARER = 'gl_Position.z -= 0.0004 * gl_Position.w;';

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
  ${NEARER}
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

const LINE_VERTEX = /* glsl */ `
varying vec3 vColour;
uniform vec3 one;
void main() {
  #ifdef ONE_COLOUR
    vColour = one;
  #else
    vColour = color;
  #endif
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  ${NEARER}
}`;

const LINE_FRAGMENT = /* glsl */ `
varying vec3 vColour;
uniform float opacity;
void main() {
  gl_FragColor = vec4(vColour, opacity);
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

/** Lines of the colours of their ends, or of one colour. `behind`: only the parts that the surface hides, faintly. */
export function lineMaterial(behind: boolean, one?: Color): ShaderMaterial {
  return new ShaderMaterial({
    vertexShader: LINE_VERTEX,
    fragmentShader: LINE_FRAGMENT,
    uniforms: { one: { value: one ?? new Color() }, opacity: { value: behind ? 0.16 : 0.95 } },
    defines: one === undefined ? {} : { ONE_COLOUR: '' },
    vertexColors: one === undefined,
    transparent: true,
    depthWrite: false,
    depthFunc: behind ? GreaterDepth : LessEqualDepth,
  });
}

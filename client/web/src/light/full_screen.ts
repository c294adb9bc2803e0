// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** The vertex shader of three's FullScreenQuad; `place` goes from 0 to 1 over the picture. */
export const FULL_SCREEN_VERTEX = /* glsl */ `
  out vec2 place;
  void main() {
    place = uv;
    gl_Position = vec4(position.xy, 0.0, 1.0);
  }`;

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/**
 * Cavity shading is the mean curvature in the picture. Normals are compared over a distance, not between neighbouring
 * points of the stream, whose rounding would show as grain; not across sharp edges, which would be framed by bands.
 * Ambient occlusion is the height of the horizon in four directions (Bavoil, Sainz & Dimitrov 2008, "Image-space
 * horizon-based ambient occlusion", doi:10.1145/1401032.1401061).
 *
 * `normals` holds x y of the normal in the view and the distance along the line of sight, in sizes; 0 where nothing is.
 * Writes the curvature, 0.5 for none, the share of the sky that is hidden, and the distance.
 */
export const HOLLOWS = /* glsl */ `
  uniform sampler2D normals;
  uniform vec2 texel;
  uniform float zoom;
  uniform float isPerspective;
  uniform float size;
  in vec2 place;

  const float RADIUS = 0.02;        // of the surface's size
  const float FARTHEST = 0.04;      // of the view's height
  const float SHARP = 4.0;          // the curvature, times the size, that has half of the effect
  const float HIDDEN_WITHIN = 0.12; // of the surface's size: what is farther away hides nothing
  const float HIDDEN_REACH = 0.15;  // of the view's height, at most
  const float LOW = 0.15;           // sine of a horizon that hides nothing yet: facets are that uneven

  vec3 normalOf(vec3 texel) {
    return vec3(texel.xy, sqrt(max(1.0 - dot(texel.xy, texel.xy), 0.0)));
  }

  float unitsPerHeight(float z) {
    return mix(1.0 / size, z, isPerspective) / zoom;
  }

  /** In the view, in sizes. */
  vec3 positionOf(vec2 at, float z) {
    return vec3((at - 0.5) * vec2(texel.y / texel.x, 1.0) * unitsPerHeight(z), -z);
  }

  void main() {
    vec3 here = texture(normals, place).xyz;
    if (here.z == 0.0) {
      gl_FragColor = vec4(0.5, 0.0, 0.0, 0.0);
      return;
    }
    vec3 normal = normalOf(here);
    vec3 position = positionOf(place, here.z);
    float perHeight = unitsPerHeight(here.z);
    float reach = clamp(RADIUS / perHeight, texel.y, FARTHEST);
    float radius = reach * perHeight;  // in sizes
    float farReach = clamp(HIDDEN_WITHIN / perHeight, texel.y, HIDDEN_REACH);
    float farRadius = farReach * perHeight;
    vec2 pixel = mod(floor(place / texel), 4.0);
    float number = pixel.x + 4.0 * pixel.y;  // each of 16 pixels looks elsewhere, and the blur averages them
    float turn = number / 16.0;
    float start = fract(number * 7.0 / 16.0);  // of the steps, in another order
    float bend = 0.0;
    float weights = 1e-3;
    float hidden = 0.0;
    for (int i = 0; i < 4; ++i) {
      float angle = (float(i) + turn) * 1.570796;
      vec2 direction = vec2(cos(angle), sin(angle));
      vec2 aside = direction * vec2(texel.x / texel.y, 1.0);
      vec3 there = texture(normals, place + aside * reach).xyz;
      float near = there.z > 0.0 && abs(there.z - here.z) < 4.0 * radius ? 1.0 : 0.0;
      float weight = near * (1.0 - smoothstep(0.4, 0.8, distance(normalOf(there), normal)));  // across an edge
      bend += weight * dot(there.xy - here.xy, direction);
      weights += near;
      float horizon = LOW;
      for (int k = 0; k < 3; ++k) {
        vec2 at = place + aside * farReach * (float(k) + 0.4 + 0.6 * start) / 3.0;
        float z = texture(normals, at).z;
        vec3 towards = positionOf(at, z) - position;
        float far = length(towards);
        float fade = z > 0.0 ? max(1.0 - far * far / (farRadius * farRadius * 1.5), 0.0) : 0.0;
        horizon = max(horizon, mix(LOW, dot(towards, normal) / max(far, 1e-6), fade));
      }
      hidden += (horizon - LOW) / 4.0 / (1.0 - LOW);
    }
    float curvature = bend / (radius * weights);
    gl_FragColor = vec4(0.5 + 0.5 * curvature / (abs(curvature) + SHARP), hidden, here.z, 0.0);
  }`;

/** The average of 4 x 4 pixels on the same surface. `picture` holds what HOLLOWS writes. */
export const BLUR = /* glsl */ `
  uniform sampler2D picture;
  void main() {
    ivec2 place = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(picture, 0) - 1;
    float z = texelFetch(picture, place, 0).z;
    if (z == 0.0) {
      gl_FragColor = vec4(0.5, 0.0, 0.0, 0.0);
      return;
    }
    vec2 sum = vec2(0.0);
    float weights = 1e-4;
    for (int i = 0; i < 16; ++i) {
      vec3 other = texelFetch(picture, clamp(place + ivec2(i % 4, i / 4) - 1, ivec2(0), last), 0).xyz;
      float weight = other.z > 0.0 && abs(other.z - z) < 0.02 ? 1.0 : 1e-4;
      sum += weight * other.xy;
      weights += weight;
    }
    gl_FragColor = vec4(sum / weights, 0.0, 0.0);
  }`;

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { PATCH_TEXTURE_WIDTH } from './patch_texture';

/**
 * The surface's shaders. The mesh's matrix undoes the quantisation of positions. The CPU computes it in double,
 * relative to the camera. The vertex shader decodes octahedral normals (formula of view.proto, ENCODING_QUANTISED).
 *
 * Defines: FLOAT_POINTS (RAW), HAS_NORMALS, BOXES, DISPLACEMENT, DIFFERENCE, TEXTURED, WEIGHTS (colour), LINES, GHOST (the rest
 * shape), FLAT (the shape if only vertices moved), SPLIT (FLAT left of the divider, the surface right of it).
 * patchPlace is an entry of PatchPlaces.places: facts of a patch are found by its number. Lines
 * are where a barycentric times the segments is an integer. SIDES: of triangles, drawn as lines. OWN_COLOUR: the shading has the colour. NORMALS: normals and
 * distances for the cavity shading, in place of colours.
 */
export const VERTEX_SHADER = /* glsl */ `
  precision highp float;
  precision highp int;
  uniform float whole;
  uniform float octahedralMax;
  uniform vec3 toRest;
  uniform float step;
  uniform highp sampler2D restCorners;
  uniform highp sampler2D flatCorners;
  uniform highp sampler2D boxColours;
  uniform highp sampler2D patchUvs;
  uniform highp sampler2D patchWeights;
  in uvec2 patchPlace;
  #ifdef FLOAT_POINTS
    in vec3 pointNormal;
  #else
    in vec2 octahedral;
  #endif
  out vec3 viewPosition;
  out vec3 viewNormal;
  out vec3 gridPlace;
  out vec3 boxColour;
  out vec2 textureUv;
  flat out float textureLayer;
  out float displacement;

  vec4 patchTexel(highp sampler2D data, int texel) {
    return texelFetch(data, ivec2(texel % ${PATCH_TEXTURE_WIDTH}, texel / ${PATCH_TEXTURE_WIDTH}), 0);
  }

  /** A point of a patch's flat triangle. */
  vec3 inTriangle(highp sampler2D corners, int patchNumber, vec3 weights) {
    return weights.x * patchTexel(corners, 3 * patchNumber).xyz +
           weights.y * patchTexel(corners, 3 * patchNumber + 1).xyz +
           weights.z * patchTexel(corners, 3 * patchNumber + 2).xyz;
  }

  vec3 decodedNormal() {
    #ifdef FLOAT_POINTS
      return pointNormal;
    #else
      float y = 2.0 * octahedral.x / octahedralMax - 1.0;
      float z = 2.0 * octahedral.y / octahedralMax - 1.0;
      float x = 1.0 - abs(y) - abs(z);
      if (x < 0.0) {
        y += y < 0.0 ? -x : x;
        z += z < 0.0 ? -x : x;
      }
      return normalize(vec3(x, y, z));
    #endif
  }

  void main() {
    int patchNumber = int(patchPlace.x);
    vec2 inPatch = vec2(patchPlace.y & 0xffffu, patchPlace.y >> 16);
    gridPlace = vec3(whole - inPatch.x - inPatch.y, inPatch);
    vec3 place = position;
    vec3 weights = gridPlace / whole;
    #if defined(GHOST)
      place = inTriangle(restCorners, patchNumber, weights);
    #elif defined(FLAT)
      place = inTriangle(flatCorners, patchNumber, weights);
    #endif
    #if defined(DISPLACEMENT)
      displacement = length(position * step + toRest - inTriangle(restCorners, patchNumber, weights));
    #elif defined(WEIGHTS)
      displacement = dot(weights, patchTexel(patchWeights, patchNumber).xyz);
    #elif defined(DIFFERENCE)
      displacement = length(position * step + toRest - inTriangle(flatCorners, patchNumber, weights));
    #endif
    #ifdef BOXES
      boxColour = patchTexel(boxColours, patchNumber).rgb;
    #endif
    #ifdef TEXTURED
      vec4 first = patchTexel(patchUvs, 2 * patchNumber);
      vec4 second = patchTexel(patchUvs, 2 * patchNumber + 1);
      textureUv = weights.x * first.xy + weights.y * first.zw + weights.z * second.xy;
      textureLayer = second.z;
    #endif
    #ifdef HAS_NORMALS
      viewNormal = normalMatrix * decodedNormal();
    #endif
    vec4 inView = modelViewMatrix * vec4(place, 1.0);
    viewPosition = inView.xyz;
    gl_Position = projectionMatrix * inView;
  }
`;

export const FRAGMENT_SHADER = /* glsl */ `
  precision highp float;
  uniform vec3 baseColour;
  uniform vec3 lineColour;
  uniform float wireframe;
  uniform float patchEdges;
  uniform float opacity;
  uniform float divider;
  uniform float displacementRange;
  uniform highp sampler2DArray map;
  uniform sampler2D shading;
  uniform sampler2D hollows;
  uniform vec2 viewSize;
  uniform float size;
  uniform vec2 tones;
  in vec3 viewPosition;
  in vec3 viewNormal;
  in vec3 gridPlace;
  in vec3 boxColour;
  in vec2 textureUv;
  flat in float textureLayer;
  in float displacement;

  // Dark blue, blue, green, yellow, red over 0 to 1.
  vec3 heat(float value) {
    float t = clamp(value, 0.0, 1.0) * 4.0;
    vec3 low = mix(vec3(0.09, 0.11, 0.35), vec3(0.13, 0.44, 0.71), clamp(t, 0.0, 1.0));
    vec3 mid = mix(low, vec3(0.35, 0.72, 0.48), clamp(t - 1.0, 0.0, 1.0));
    vec3 high = mix(mid, vec3(0.95, 0.83, 0.30), clamp(t - 2.0, 0.0, 1.0));
    return mix(high, vec3(0.80, 0.16, 0.13), clamp(t - 3.0, 0.0, 1.0));
  }

  // Lines closer than a few pixels would be one dark area: they fade.
  float apart(float density) {
    return mix(1.0, 0.25, smoothstep(0.15, 0.5, density));
  }

  vec3 surfaceColour() {
    #if defined(BOXES)
      return boxColour;
    #elif defined(DISPLACEMENT) || defined(DIFFERENCE)
      return heat(displacement / max(displacementRange, 1e-30));
    #elif defined(WEIGHTS)
      return heat(displacement);
    #elif defined(TEXTURED)
      return texture(map, vec3(textureUv, textureLayer)).rgb;
    #elif defined(OWN_COLOUR)
      return vec3(1.0);
    #else
      return baseColour;
    #endif
  }

  // The normal on the side of the eye. At a silhouette triangles are seen whose normals already face away a little: these
  // normals are bent to lie across the line of sight, since turned around they would be lit from the other side. A normal
  // that faces away far is that of a back side, and is turned around.
  vec3 towardsEye(vec3 normal, vec3 toEye) {
    float away = -dot(normal, toEye);
    if (away <= 0.0) return normal;
    vec3 across = normal + away * toEye;
    return normalize(mix(across, away * toEye - across, smoothstep(0.35, 0.7, away)) + 1e-4 * toEye);
  }

  // The lit ball's picture at the place with this normal, in a view straight towards the surface.
  vec4 shadeOf(vec3 normal, vec3 toEye) {
    vec3 right = normalize(vec3(toEye.z, 0.0, -toEye.x));
    return texture(shading, vec2(dot(right, normal), dot(cross(toEye, right), normal)) * 0.48 + 0.5);
  }

  // Darker in hollows and where the sky is hidden, lighter on ridges.
  float cavity() {
    vec2 found = texture(hollows, gl_FragCoord.xy / viewSize).rg;
    float bend = 2.0 * found.r - 1.0;
    return (1.0 + bend * (bend < 0.0 ? 0.7 : 0.35)) * (1.0 - found.g);
  }

  // The same colour, its luminance hardly below the lower tone, and compressed above the upper one.
  vec3 toned(vec3 colour) {
    float light = dot(colour, vec3(0.2126, 0.7152, 0.0722));
    float lifted = length(vec2(light, tones.x));
    float above = lifted - tones.y;
    return colour * (lifted - 0.25 * (above + length(vec2(above, 0.03)))) / max(light, 1e-4);
  }

  void main() {
    #if defined(SPLIT) && defined(FLAT)
      if (gl_FragCoord.x >= divider) discard;
    #elif defined(SPLIT)
      if (gl_FragCoord.x < divider) discard;
    #endif
    #ifdef SIDES
      gl_FragColor = vec4(lineColour, opacity);
      return;
    #endif
    vec3 toEye = isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(-viewPosition);
    #ifdef HAS_NORMALS
      vec3 normal = viewNormal == vec3(0.0) ? toEye : towardsEye(normalize(viewNormal), toEye);
    #else
      vec3 facet = normalize(cross(dFdx(viewPosition), dFdy(viewPosition)));
      vec3 normal = dot(facet, toEye) < 0.0 ? -facet : facet;
    #endif
    #ifdef NORMALS
      gl_FragColor = vec4(normal.xy, -viewPosition.z / size, 1.0);  // in sizes: half floats end at 65,504
      return;
    #endif
    vec4 shade = shadeOf(normal, toEye);
    #if defined(BOXES) || defined(DISPLACEMENT) || defined(DIFFERENCE) || defined(TEXTURED) || defined(WEIGHTS)
      shade = vec4(0.3 + 0.45 * shade.rgb, 0.5 * shade.a);  // less light and shade, so that colours can be told apart
    #endif
    vec3 colour = surfaceColour() * shade.rgb + shade.a;
    #if !defined(BOXES) && !defined(DISPLACEMENT) && !defined(DIFFERENCE) && !defined(TEXTURED) && !defined(WEIGHTS)
      colour = toned(colour);
    #endif
    #ifdef HAS_NORMALS
      colour *= cavity();
    #endif
    #ifdef LINES
      vec3 width = max(fwidth(gridPlace), 1e-6);
      vec3 toLine = abs(fract(gridPlace + 0.5) - 0.5) / width;
      vec3 toEdge = gridPlace / width;
      float line = wireframe * clamp(1.2 - min(min(toLine.x, toLine.y), toLine.z), 0.0, 1.0);
      float edge = patchEdges * clamp(1.7 - min(min(toEdge.x, toEdge.y), toEdge.z), 0.0, 1.0);
      float density = max(max(width.x, width.y), width.z);  // lines per pixel
      float patchDensity = density / (gridPlace.x + gridPlace.y + gridPlace.z);
      colour = mix(colour, lineColour, max(0.55 * line * apart(density), 0.85 * edge * apart(patchDensity)));
    #endif
    gl_FragColor = vec4(colour, opacity);
    #include <colorspace_fragment>
  }
`;

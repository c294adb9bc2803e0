#version 300 es
// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates points of patches, as patches.proto defines: one vertex is one point. Transform feedback takes `point` and
// `pointNormal`; there is nothing to draw. The shader stands alone: any program with OpenGL ES 3.0 can compile this file.
//
// Defines   DEGREE_0, DEGREE_1, DEGREE_2: the lattice's degree on each axis, 1 to 3; inserted after the first line. WEIGHTED: the
//           vertices have weights
// Textures  their rows are WIDTH texels long, and texels are numbered row by row. Sampled by texelFetch alone:
//   patches   RGBA32I, four texels a patch. Texels 0 to 2 are its corners: x y z are the place of the corner less 65535
//             times the patch's span on each axis, w is the number of its rest normal. Texel 3: x is the number of the
//             patch's box, or 0 for the outside box; y has bit a set if the patch's span on axis a is above 0, and bit
//             3 + a if derivatives do not jump at the lower end of that span (nowhere is right too); z is 0, or one
//             more than the number of its seam record; w is 0. With weights, the upper 16 bits of x of a corner are its weight
//   seams     RGBA32I, three texels a record, one for each corner k: x y z are its places in the outside box; w has
//             bit 0 set while the corner's seam is attached, and bit 1 while that of edge k is
//   boxes     RGBA32F, COEFFICIENTS texels a box. Texel i + (DEGREE_0 + 1) (j + (DEGREE_1 + 1) k) has in x y z the factor
//             of l_0^i l_1^j l_2^k in the position relative to the origin. The w of texel (1,0,0) is the width of the
//             box's span on axis 0, that of (0,1,0) on axis 1, that of (0,0,1) on axis 2; only their ratios count. With weights the w
//             of (0,0,0), (1,1,0) and (1,0,1) are x, y and z of the middle of the box at rest, relative to the origin. Box 0
//             is the outside box; the box of spans a, b, c has the number 1 + a boxSteps.x + b boxSteps.y + c boxSteps.z
//   normals   RGBA32F, a texel for each rest normal; with weights then one for each patch, the slope of its weight
// Speed     no indices that are known only at run time, no division of integers, and the inner loop is written out: a
//           GPU in software takes half the time
// Result    the same integers give the same bits of `point` in one call of a program, whatever the patch
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp isampler2D;

#ifndef DEGREE_0
#define DEGREE_0 2
#define DEGREE_1 2
#define DEGREE_2 2
#endif

const int WIDTH_BITS = 11;
const int WIDTH = 1 << WIDTH_BITS;
const int COEFFICIENTS = (DEGREE_0 + 1) * (DEGREE_1 + 1) * (DEGREE_2 + 1);
const int KNOT = 65535;  // a span in places
const uint NONE = 0xffffffffu;
const int CORNER_ATTACHED = 1;
const int EDGE_ATTACHED = 2;

uniform isampler2D patches;
uniform isampler2D seams;
uniform sampler2D boxes;
uniform sampler2D normals;
uniform int denominator;  // the sum of a point's three integers: a power of two, at most 4096
uniform ivec3 boxSteps;  // the step of a box's number along each axis
#ifdef WEIGHTED
uniform mat3 restEdges;  // column a: the world position's change at rest per unit of axis a, in world units
uniform int slopesAt;  // the texel of the first patch's slope
#endif
uniform mat3 conormals;  // column a: the world position's change at rest along axis a; all negative in a left-handed frame

in uvec2 patchPlace;  // the patch, and i_1 | i_2 << 16 of the point; i_0 is the rest of the denominator. Patch NONE: no point

out vec3 point;  // relative to the origin, in world units
out vec3 pointNormal;  // of unit length, or zero where none is defined

ivec4 integersAt(isampler2D data, int texel) {
  return texelFetch(data, ivec2(texel & (WIDTH - 1), texel >> WIDTH_BITS), 0);
}

vec4 numbersAt(sampler2D data, int texel) {
  return texelFetch(data, ivec2(texel & (WIDTH - 1), texel >> WIDTH_BITS), 0);
}

// From sums of places to -1/2 to 1/2. Only the conversion to float and the product round.
vec3 localCoordinates(ivec3 sums) {
  return vec3(2 * sums - KNOT * denominator) * (0.5 / float(KNOT * denominator));
}

// A box's polynomial at l, and its derivatives along the axes: nested Horner schemes.
void evaluate(int box, vec3 l, out vec3 value, out mat3 derivatives) {
  value = vec3(0.0);
  derivatives = mat3(0.0);
  int at = COEFFICIENTS * (box + 1);
  for (int k = DEGREE_2; k >= 0; --k) {
    vec3 plane = vec3(0.0);
    vec3 plane0 = vec3(0.0);
    vec3 plane1 = vec3(0.0);
    for (int j = DEGREE_1; j >= 0; --j) {
      vec3 line0 = numbersAt(boxes, --at).xyz;
      vec3 line = line0 * l.x + numbersAt(boxes, --at).xyz;
#if DEGREE_0 > 1
      line0 = line0 * l.x + line;
      line = line * l.x + numbersAt(boxes, --at).xyz;
#endif
#if DEGREE_0 > 2
      line0 = line0 * l.x + line;
      line = line * l.x + numbersAt(boxes, --at).xyz;
#endif
      plane1 = plane1 * l.y + plane;
      plane0 = plane0 * l.y + line0;
      plane = plane * l.y + line;
    }
    derivatives[2] = derivatives[2] * l.z + value;
    derivatives[1] = derivatives[1] * l.z + plane1;
    derivatives[0] = derivatives[0] * l.z + plane0;
    value = value * l.z + plane;
  }
}

vec3 widthsOf(int box) {
  int first = COEFFICIENTS * box;
  return vec3(numbersAt(boxes, first + 1).w, numbersAt(boxes, first + DEGREE_0 + 1).w,
              numbersAt(boxes, first + (DEGREE_0 + 1) * (DEGREE_1 + 1)).w);
}

#ifdef WEIGHTED
// From R and its derivatives to X + w (R - X) and its derivatives, X the point at rest.
void weigh(int box, vec3 l, float weight, vec3 slope, inout vec3 value, inout mat3 derivatives) {
  if (box == 0) return;
  int first = COEFFICIENTS * box;
  vec3 atRest = vec3(numbersAt(boxes, first).w, numbersAt(boxes, first + 1 + DEGREE_0 + 1).w,
                     numbersAt(boxes, first + 1 + (DEGREE_0 + 1) * (DEGREE_1 + 1)).w);
  vec3 widths = widthsOf(box);
  mat3 edges = mat3(widths.x * restEdges[0], widths.y * restEdges[1], widths.z * restEdges[2]);
  atRest += l.x * edges[0] + l.y * edges[1] + l.z * edges[2];
  vec3 offset = value - atRest;
  value = atRest + weight * offset;
  derivatives[0] = edges[0] + weight * (derivatives[0] - edges[0]) + dot(slope, edges[0]) * offset;
  derivatives[1] = edges[1] + weight * (derivatives[1] - edges[1]) + dot(slope, edges[1]) * offset;
  derivatives[2] = edges[2] + weight * (derivatives[2] - edges[2]) + dot(slope, edges[2]) * offset;
}
#endif

void main() {
  point = pointNormal = vec3(0.0);
  if (patchPlace.x == NONE) return;
  int patchNumber = int(patchPlace.x);
  ivec3 weights;
  weights.y = int(patchPlace.y & 0xffffu);
  weights.z = int(patchPlace.y >> 16);
  weights.x = denominator - weights.y - weights.z;
  ivec4 corner0 = integersAt(patches, 4 * patchNumber);
  ivec4 corner1 = integersAt(patches, 4 * patchNumber + 1);
  ivec4 corner2 = integersAt(patches, 4 * patchNumber + 2);
  ivec4 facts = integersAt(patches, 4 * patchNumber + 3);
#ifdef WEIGHTED
  // The sum is an exact integer, so that a point that patches share has the same weight in all of them.
  ivec3 cornerWeights = (ivec3(corner0.x, corner1.x, corner2.x) >> 16) & 0xffff;
  int sumOfWeights = weights.x * cornerWeights.x + weights.y * cornerWeights.y + weights.z * cornerWeights.z;
  float weight = float(sumOfWeights) / float(KNOT * denominator);
  vec3 slope = numbersAt(normals, slopesAt + patchNumber).xyz;
  corner0.x &= 0xffff;
  corner1.x &= 0xffff;
  corner2.x &= 0xffff;
#endif
  ivec3 own = weights.x * corner0.xyz + weights.y * corner1.xyz + weights.z * corner2.xyz;

  // A point on a knot plane counts as of the lower box, so that it has the same place in all patches.
  ivec3 isLower = ivec3(equal(own, ivec3(0))) * ((ivec3(facts.y) >> ivec3(0, 1, 2)) & 1);
  ivec3 sums = own + KNOT * denominator * isLower;
  ivec3 steps = boxSteps * isLower;
  int box = facts.x - steps.x - steps.y - steps.z;
  if (facts.z != 0) {
    ivec4 outside0 = integersAt(seams, 3 * facts.z - 3);
    ivec4 outside1 = integersAt(seams, 3 * facts.z - 2);
    ivec4 outside2 = integersAt(seams, 3 * facts.z - 1);
    ivec3 attached = ivec3(outside0.w, outside1.w, outside2.w);
    ivec3 corners = ivec3(equal(weights, ivec3(denominator))) * (attached & CORNER_ATTACHED);
    ivec3 edges = ivec3(equal(weights.zxy, ivec3(0))) * (attached & EDGE_ATTACHED);
    if ((corners | edges) != ivec3(0)) {
      sums = weights.x * outside0.xyz + weights.y * outside1.xyz + weights.z * outside2.xyz;
      box = 0;
    }
  }
  vec3 position;
  mat3 derivatives;
  evaluate(box, localCoordinates(sums), position, derivatives);  // of all points alike: the bits must not depend on the patch
#ifdef WEIGHTED
  weigh(box, localCoordinates(sums), weight, slope, position, derivatives);
#endif
  point = position;

  vec3 atRest = float(weights.x) * numbersAt(normals, corner0.w).xyz + float(weights.y) * numbersAt(normals, corner1.w).xyz +
                float(weights.z) * numbersAt(normals, corner2.w).xyz;
  vec3 direction = vec3(0.0);
  if (facts.x != 0) {
    // Where derivatives jump at a knot plane, normals need the patch's own box.
    bool hasJump = (isLower & ~(ivec3(facts.y) >> ivec3(3, 4, 5))) != ivec3(0);
    if (box == 0 || hasJump) {
      evaluate(facts.x, localCoordinates(own), position, derivatives);
#ifdef WEIGHTED
      weigh(facts.x, localCoordinates(own), weight, slope, position, derivatives);
#endif
    }
    vec3 h = widthsOf(box == 0 || hasJump ? facts.x : box) * (atRest * conormals);
    direction = h.x * cross(derivatives[1], derivatives[2]) + h.y * cross(derivatives[2], derivatives[0]) +
                h.z * cross(derivatives[0], derivatives[1]);
  }
  if (direction == vec3(0.0)) direction = atRest;
  direction /= max(max(abs(direction.x), abs(direction.y)), max(abs(direction.z), 1e-37));  // squares must not underflow
  pointNormal = direction == vec3(0.0) ? direction : normalize(direction);
}

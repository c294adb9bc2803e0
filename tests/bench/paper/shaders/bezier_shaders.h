// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The text of the shaders that tessellate triangular Bézier surfaces.
//                                                                 Cui & Feng 2014, formula (3)
//
//   X(b) = b0 X0 + b1 X1 + b2 X2,   Xc = sum_{i+j+k = n-1} B^{n-1}_ijk(b) T_{ijk + e_c}
//   Pu = n (X1 - X0),  Pv = n (X2 - X0),  normal = Pu x Pv / |…|
//
// Unrolled, multinomials as literals: each control point is read once and weighs in three sums, 189
// multiply-adds at n = 6.
//
// Outputs  position (relative to the plan's local origin), normal, coordinate (gl_TessCoord, of which
//          b1 and b2 count) and patch_index. Patches are counted by gl_VertexID: gl_PrimitiveID
//          starts again where Mesa cuts a long draw into several
// Uniform  view_scale, of position to clip space
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_BEZIER_SHADERS_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_BEZIER_SHADERS_H_

#include <string>

namespace latticed::bench {

// How control points reach the evaluation shader.
enum class NetSource {
  kVertices,  // m + 1 vertices a patch: degree 6 and less, since OpenGL promises 32
  kBuffer,    // a patch of one vertex; a storage buffer at binding 0
};

// The largest number of vertices that a patch may have everywhere.
inline constexpr int kMostPatchVertices = 32;

struct BezierShaders {
  std::string vertex, control, evaluation, fragment;
};

// All outer levels and the inner one are `level`.
[[nodiscard]] BezierShaders MakeBezierShaders(int degree, int level, NetSource source);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_BEZIER_SHADERS_H_

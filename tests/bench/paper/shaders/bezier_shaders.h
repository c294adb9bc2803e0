// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Builds the source of the shaders that tessellate triangular Bézier surfaces.
//                                                                 Cui & Feng 2014, formula (3)
//
//   X(b) = b0 X0 + b1 X1 + b2 X2,   Xc = sum_{i+j+k = n-1} B^{n-1}_ijk(b) T_{ijk + e_c}
//   Pu = n (X1 - X0),  Pv = n (X2 - X0),  normal = Pu x Pv / |…|
//
// The loops are unrolled, with multinomials as literals. Each control point is read once and weighs
// in three sums: 189 multiply-adds at n = 6.
//
// Outputs  position (relative to the plan's local origin), normal, coordinate (gl_TessCoord; its b1
//          and b2 are used) and patch_index. Patches are counted by gl_VertexID, because
//          gl_PrimitiveID restarts where Mesa cuts a long draw into several
// Uniform  view_scale, the scale from position to clip space
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_BEZIER_SHADERS_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_BEZIER_SHADERS_H_

#include <string>

namespace latticed::bench {

// How control points reach the evaluation shader.
enum class NetSource {
  kVertices,  // m + 1 vertices per patch: up to degree 6, since OpenGL promises 32
  kBuffer,    // one vertex per patch; a storage buffer at binding 0
};

// The largest number of vertices per patch that every OpenGL allows.
inline constexpr int kMostPatchVertices = 32;

struct BezierShaders {
  std::string vertex, control, evaluation, fragment;
};

// All outer levels and the inner level are `level`.
[[nodiscard]] BezierShaders MakeBezierShaders(int degree, int level, NetSource source);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_BEZIER_SHADERS_H_

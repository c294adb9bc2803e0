// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How coordinates in a lattice's frame change in the world, and how far J_g is from I in a knot box.
//
//   r_a = e_b x e_c / det(e)              the gradient of coordinate a, which runs from 0 to 1 along the edge e_a
//   p_a = |e_b| x |e_c| / |det(e)|        the same with moduli instead of numbers
//   k   = |e_u| . |e_v| x |e_w| / |det(e)|   the condition: 1 for edges along the world's axes, below 1.2 for other
//                                           orthogonal edges
//
// r_a is within (3 + 5 k) 2^-53 p_a of the true one.
//
// Threads  pure functions
#ifndef LATTICED_CORE_FOLDS_FRAME_GRADIENTS_H_
#define LATTICED_CORE_FOLDS_FRAME_GRADIENTS_H_

#include <array>
#include <cmath>
#include <span>

#include "core/base/vec.h"
#include "core/ffd/box/bezier_box.h"
#include "core/ffd/lattice.h"

namespace latticed {

[[nodiscard]] inline Vec3d Moduli(Vec3d v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
// The cross product with moduli instead of numbers.
[[nodiscard]] inline Vec3d CrossOfModuli(Vec3d a, Vec3d b) {
  const auto of = [&](int i, int j) { return std::abs(a[i] * b[j]) + std::abs(a[j] * b[i]); };
  return {of(1, 2), of(2, 0), of(0, 1)};
}
[[nodiscard]] inline double DotOfModuli(Vec3d a, Vec3d b) {
  return std::abs(a.x * b.x) + std::abs(a.y * b.y) + std::abs(a.z * b.z);
}

struct FrameGradients {
  std::array<Vec3d, 3> gradients, sizes;  // r_a and p_a
  double condition = 1;                   // k

  explicit FrameGradients(const LatticeFrame& frame);
};

// The derivatives R_a of a lattice by the coordinates of a knot box, over the box.
struct SlopesOfBox {
  std::array<double, 3> widths{};   // of the box, in those of the domain
  std::array<BezierBox, 3> slopes;  // R_a
  std::array<double, 3> most{};     // the largest component of the differences that they come from

  SlopesOfBox() = default;
  SlopesOfBox(const LatticeStructure& structure, std::span<const Vec3d> points,
              const std::array<int, 3>& span);
  // A bound of |J_g - I| in the box, rounding included: |J_g - I| <= sum over a |R_a - e_a| |r_a|.
  [[nodiscard]] double RiseOver(const LatticeFrame& frame, const FrameGradients& gradients) const;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_FRAME_GRADIENTS_H_

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/frame_gradients.h"

#include "core/folds/box_slopes.h"

namespace latticed {

FrameGradients::FrameGradients(const LatticeFrame& frame) {
  const auto& e = frame.edges;
  const double volume = Dot(e[0], Cross(e[1], e[2]));
  for (size_t a = 0; a < 3; ++a) {
    const Vec3d &b = e[(a + 1) % 3], &c = e[(a + 2) % 3];
    gradients[a] = Cross(b, c) / volume;
    sizes[a] = CrossOfModuli(b, c) / std::abs(volume);
  }
  condition = DotOfModuli(e[0], sizes[0]);
}

SlopesOfBox::SlopesOfBox(const LatticeStructure& s, std::span<const Vec3d> points,
                         const std::array<int, 3>& span) {
  const BoxPart part = WholeBox(s, span);
  for (size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<int>(a);
    widths[a] = (part.upper[axis] - part.lower[axis]) / (s.domain_end(axis) - s.domain_begin(axis));
  }
  const BoxSlopes derivatives(s, points, part);
  for (size_t a = 0; a < 3; ++a) most[a] = derivatives.Along(a, slopes[a]);
}

double SlopesOfBox::RiseOver(const LatticeFrame& frame, const FrameGradients& of) const {
  double rise = 0;
  for (size_t a = 0; a < 3; ++a) {
    const Vec3d edge = widths[a] * frame.edges[a];
    const double largest =
        LargestPoint(slopes[a], [edge](Vec3d slope) { return Norm(slope - edge); });
    // 72 u of the differences, 4 u of the edge, (3 + 5 k) u of r_a, and what sums lose: with room to spare, because the
    // largest component is smaller than the length.
    const double rounding =
        (13'200 + 120 * of.condition) * 0x1p-53 * (most[a] + Norm(edge)) * Norm(of.sizes[a]);
    rise += (largest * Norm(of.gradients[a]) + rounding) / widths[a];
  }
  return rise;
}

}  // namespace latticed

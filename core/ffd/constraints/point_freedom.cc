// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/constraints/point_freedom.h"

#include <algorithm>
#include <cmath>

#include "core/ffd/edit/lattice_edit.h"

namespace latticed {
namespace {

constexpr double kRounding = 1e-13;  // of the frame's size

double SizeOf(const LatticeFrame& frame) {
  double size = Norm(frame.origin);
  for (const Vec3d& edge : frame.edges) size = std::max(size, Norm(edge));
  return size;
}

}  // namespace

PointFreedom::PointFreedom(const Constraints& constraints, const LatticeStructure& s)
    : held_(static_cast<size_t>(s.control_point_count())) {
  for (size_t a = 0; a < 3; ++a) size_[a] = static_cast<size_t>(s.size[a]);
  for (const uint32_t index : constraints.held) held_[index] = true;
  for (size_t n = 0; n < held_.size(); ++n) {
    const std::array<size_t, 3> at{n % size_[0], n / size_[0] % size_[1], n / size_[0] / size_[1]};
    for (const HeldLayers& layers : constraints.held_layers) {
      const auto axis = static_cast<size_t>(layers.axis);
      const size_t layer = layers.at_end ? size_[axis] - 1 - at[axis] : at[axis];
      if (layer < static_cast<size_t>(layers.layers)) held_[n] = true;
    }
  }
  if (!constraints.mirror.has_value()) return;
  const auto axis = static_cast<size_t>(*constraints.mirror);
  const auto& [origin, edges] = s.frame;
  mirror_ = Mirror{.axis = axis,
                   .normal = edges[axis] / Norm(edges[axis]),
                   .centre = origin + 0.5 * (edges[0] + edges[1] + edges[2]),
                   .rounding = kRounding * SizeOf(s.frame)};
  identity_ = IdentityControlPoints(s);
  for (size_t n = 0; n < held_.size(); ++n) {
    if (held_[n]) held_[ImageOf(n)] = true;
  }
}

size_t PointFreedom::ImageOf(size_t index) const {
  const size_t axis = mirror_->axis;
  const size_t step = axis == 0 ? 1 : axis == 1 ? size_[0] : size_[0] * size_[1];
  const size_t at = index / step % size_[axis];
  return index + (size_[axis] - 1 - at) * step - at * step;
}

std::vector<uint32_t> PointFreedom::Symmetrise(std::span<const uint32_t> named,
                                               std::vector<Vec3d>& points) const {
  std::vector<uint32_t> written;
  std::vector<bool> is_named(held_.size());
  for (const uint32_t index : named) is_named[index] = true;
  for (const uint32_t index : named) {
    const size_t image = ImageOf(index);
    Vec3d &p = points[index], &other = points[image];
    if (is_named[image]) {
      if (Norm(other - Image(p)) <= mirror_->rounding) continue;
      const Vec3d middle = 0.5 * (p + Image(other));
      p = middle;
      other = image == index ? middle : Image(middle);
      continue;
    }
    other = SameBits(p, identity_[index]) ? identity_[image] : Image(p);
    written.push_back(static_cast<uint32_t>(image));
  }
  return written;
}

void PointFreedom::SymmetriseMoves(std::vector<Vec3d>& moves) const {
  for (size_t n = 0; n < moves.size(); ++n) {
    const size_t image = ImageOf(n);
    if (image < n) continue;
    moves[n] = 0.5 * (moves[n] + Reflect(moves[image]));
    moves[image] = Reflect(moves[n]);
  }
}

}  // namespace latticed

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/backend/definition.h"

#include <algorithm>
#include <limits>

#include "core/ffd/tessellation_pattern.h"

namespace latticed::testing {
namespace {

Bounds InfluencingControlPoints(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  Bounds bounds;
  const LatticeStructure& s = plan.structure;
  for (uint32_t b = 0; b < plan.outside_box(); ++b) {
    if (plan.box_patches[b] == plan.box_patches[b + 1]) continue;
    const auto& span = plan.boxes[b].span;
    for (int k = span[2] - s.degree[2]; k <= span[2]; ++k) {
      for (int j = span[1] - s.degree[1]; j <= span[1]; ++j) {
        for (int i = span[0] - s.degree[0]; i <= span[0]; ++i) {
          bounds.Extend(control_points[static_cast<size_t>(s.Index(i, j, k))]);
        }
      }
    }
  }
  return bounds;
}

}  // namespace

Definition::Definition(const DeformPlan& plan, std::span<const Vec3d> control_points, int segments,
                       NormalMode normals, size_t stride)
    : plan_(plan),
      direct_(plan, control_points),
      kind_(normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth
                                           : DirectFfd::Normal::kFacet),
      stride_(stride) {
  const double over = 1.0 / segments;
  for (const auto& t : TessellationPattern::Get(segments).points) {
    barycentrics_.push_back({t[0] * over, t[1] * over, t[2] * over});
  }
  Bounds deformed;
  for (size_t p = 0; p < plan.patches.size(); p += stride) {
    Bounds of_patch;
    for (const auto& b : barycentrics_) {
      points_.push_back(direct_.Evaluate(p, b, kind_));
      of_patch.Extend(points_.back().position);
    }
    patch_diagonals_.push_back(of_patch.diagonal());
    deformed.Extend(of_patch);
  }
  scale_ = std::max(deformed.diagonal(), InfluencingControlPoints(plan, control_points).diagonal());
  // A surface collapsed to a point has no size of its own: its distance is what float32 must hold.
  if (scale_ == 0) scale_ = Norm(deformed.center() - plan.local_origin);
}

double Definition::NormalTolerance(Pipeline pipeline, size_t patch, size_t i) const {
  const double kappa = Point(patch, i).kappa;
  if (!(kappa <= kMostKappa)) return std::numeric_limits<double>::infinity();
  return testing::NormalTolerance(pipeline, plan_, direct_,
                                  {.patch = patch,
                                   .barycentrics = barycentrics_[i],
                                   .kind = kind_,
                                   .kappa = kappa,
                                   .patch_diagonal = patch_diagonals_[patch / stride_]});
}

}  // namespace latticed::testing

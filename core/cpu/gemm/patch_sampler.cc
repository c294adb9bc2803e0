// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/patch_sampler.h"

#include <algorithm>

namespace latticed {
namespace {

void CopyColumns(const points::BlockVec& from, size_t count, double* to, size_t stride) {
  for (size_t a = 0; a < 3; ++a) std::copy_n(from[a].begin(), count, to + a * stride);
}

}  // namespace

PatchSampler::PatchSampler(const DeformPlan& plan, const StageMatrices& stage,
                           std::span<const Vec3d> control_points)
    : sums_(plan, control_points),
      corners_{0, stage.m - 1 - static_cast<size_t>(stage.degree), stage.m - 1} {
  samples_.count = stage.m;
  for (size_t i = 0; i < stage.m; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      samples_.barycentrics[c][i] = stage.samples[i][c] / static_cast<double>(stage.degree);
    }
  }
}

Vec3d PatchSampler::Sample(size_t patch, double* positions, double* by_normal, Vec3d facet_normal,
                           size_t stride) const {
  const size_t count = samples_.count;
  patch_sums::Values values;
  sums_.Evaluate(patch, samples_, std::span(&facet_normal, by_normal == nullptr ? 0 : 1), values);
  Vec3d centre;
  for (size_t a = 0; a < 3; ++a) {
    auto& column = values.position[a];
    const double mean = (column[corners_[0]] + column[corners_[1]] + column[corners_[2]]) / 3.0;
    for (size_t i = 0; i < count; ++i) column[i] -= mean;
    centre[static_cast<int>(a)] = mean;
  }
  CopyColumns(values.position, count, positions, stride);
  if (by_normal != nullptr) CopyColumns(values.along[0], count, by_normal, stride);
  return centre;
}

}  // namespace latticed

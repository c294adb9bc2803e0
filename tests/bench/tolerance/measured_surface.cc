// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/tolerance/measured_surface.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "core/adaptive/adaptive_pattern.h"
#include "core/base/bounds.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

using Barycentrics = std::array<double, 3>;

// The pattern of one patch in the form that both kinds of views share.
struct Pattern {
  std::vector<Barycentrics> points;
  std::vector<std::array<uint16_t, 3>> triangles;
};

template <class Points>
Pattern MakePattern(const Points& points, std::vector<std::array<uint16_t, 3>> triangles,
                    int denominator) {
  Pattern pattern{.triangles = std::move(triangles)};
  for (const auto& p : points) {
    pattern.points.push_back({static_cast<double>(p[0]) / denominator,
                              static_cast<double>(p[1]) / denominator,
                              static_cast<double>(p[2]) / denominator});
  }
  return pattern;
}

Pattern PatternOf(const DeformView& view, std::span<const uint16_t> codes, size_t patch) {
  if (codes.empty()) {
    const auto& uniform = TessellationPattern::Get(view.spec().segments);
    return MakePattern(uniform.points, uniform.triangles, uniform.segments);
  }
  const auto& adaptive = AdaptivePattern::Get(*PatternKey::FromCode(codes[patch]));
  return MakePattern(adaptive.points, adaptive.triangles, adaptive.denominator);
}

double PatchError(const DirectFfd& definition, size_t patch, const Pattern& pattern,
                  std::span<const Vec3d> points) {
  constexpr double kThird = 1.0 / 3;
  constexpr std::array<Barycentrics, 4> kSamples{
      {{kThird, kThird, kThird}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}}};
  double largest = 0;
  for (const auto& triangle : pattern.triangles) {
    for (const Barycentrics& weight : kSamples) {
      Vec3d chord;
      Barycentrics at{};
      for (size_t c = 0; c < 3; ++c) {
        chord += weight[c] * points[triangle[c]];
        for (size_t a = 0; a < 3; ++a) at[a] += weight[c] * pattern.points[triangle[c]][a];
      }
      largest = std::max(largest, Norm(definition.EvaluatePosition(patch, at).position - chord));
    }
  }
  return largest;
}

}  // namespace

MeasuredSurface MeasureSurface(DeformView& view, const DeformPlan& plan,
                               std::span<const Vec3d> control_points, size_t stride) {
  const DirectFfd definition(plan, control_points);
  const size_t point_bytes = BytesPerPoint(view.spec());
  MeasuredSurface surface;
  Bounds bounds;
  std::vector<uint8_t> bytes;
  for (uint32_t chunk = 0; chunk < plan.chunk_count(); ++chunk) {
    bytes.resize(ChunkPoints(view, plan, chunk) * point_bytes);
    CheckOk(view.Read(chunk, bytes));
    const auto codes = view.Patterns().OfChunk(chunk);
    const auto [first, last] = plan.ChunkPatches(chunk);
    size_t at = 0;
    for (size_t p = first; p < last; ++p) {
      const Pattern pattern = PatternOf(view, codes, p - first);
      std::vector<Vec3d> points(pattern.points.size());
      for (Vec3d& point : points) {
        Vec3f local;
        std::memcpy(&local, &bytes[at], sizeof(local));
        at += point_bytes;
        point = plan.local_origin + ToDouble(local);
        bounds.Extend(point);
      }
      surface.points += pattern.points.size();
      surface.triangles += pattern.triangles.size();
      if (p % stride != 0) continue;
      surface.largest_error =
          std::max(surface.largest_error, PatchError(definition, p, pattern, points));
    }
  }
  surface.diagonal = bounds.diagonal();
  return surface;
}

}  // namespace latticed::bench

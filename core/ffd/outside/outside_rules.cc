// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/outside/outside_rules.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr std::array<std::string_view, 3> kAxisName{"u", "v", "w"};

// The knot span inside at a face, as a part of the domain.
double EndSpan(const LatticeStructure& s, size_t axis, bool at_end) {
  const auto& knots = s.knots[axis];
  const auto n = static_cast<size_t>(s.degree[axis]), count = static_cast<size_t>(s.size[axis]);
  const double range = knots[count] - knots[n];
  return (at_end ? knots[count] - knots[count - 1] : knots[n + 1] - knots[n]) / range;
}

bool IsClamped(const LatticeStructure& s, size_t axis, bool at_end) {
  const auto& knots = s.knots[axis];
  const auto n = static_cast<size_t>(s.degree[axis]);
  return at_end ? knots[static_cast<size_t>(s.size[axis])] == knots.back()
                : knots.front() == knots[n];
}

absl::Status CheckSide(const LatticeStructure& s, size_t axis, bool at_end) {
  const size_t side = SideOf(axis, at_end);
  const double width = s.outside.widths[side], step = s.outside.steps[side];
  const std::string path = fmt::format("lattice.outside.widths[{}]", side);
  if (!std::isfinite(width)) return error::NotFinite(path);
  if (width == 0) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(error::CheckRange(path, width, kLeastOutsideWidth, kMostOutsideWidth));
  if (!IsClamped(s, axis, at_end)) {
    return error::InvalidField(
        path, fmt::format("needs clamped knots: lattice.knots_{} must {} with a knot of "
                          "multiplicity degree + 1",
                          kAxisName[axis], at_end ? "end" : "begin"));
  }
  if (s.outside.mode != OutsideMode::kFalloff) return absl::OkStatus();
  const std::string of_step = fmt::format("lattice.outside.steps[{}]", side);
  if (!std::isfinite(step)) return error::NotFinite(of_step);
  // A knot that coincides with its neighbours would take continuity away.
  constexpr double kLeastPart = 1e-6;
  return error::CheckRange(of_step, step, kLeastPart * width, (1 - kLeastPart) * width);
}

// How many control points a side with a width adds.
int AddedBy(const LatticeStructure& s, size_t axis, bool at_end) {
  const int degree = s.degree[axis];
  if (s.outside.widths[SideOf(axis, at_end)] == 0) return 0;
  if (s.outside.mode == OutsideMode::kLinear) return degree;
  return s.outside.smooth && degree > 1 ? degree : degree + 1;
}

// As far as the points lie outside, per side, in lengths of the frame's edges.
std::array<double, 6> ReachOf(const LatticeStructure& s, std::span<const Vec3d> points) {
  const FrameMap map(s);
  std::array<double, 6> reach{};
  for (const Vec3d p : points) {
    const Vec3d at = map.ToParameter(p);
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<int>(axis);
      const double begin = s.domain_begin(a), end = s.domain_end(a);
      double& before = reach[SideOf(axis, false)];
      double& after = reach[SideOf(axis, true)];
      before = std::max(before, (begin - at[a]) / (end - begin));
      after = std::max(after, (at[a] - end) / (end - begin));
    }
  }
  return reach;
}

}  // namespace

absl::Status ValidateOutside(const LatticeStructure& s) {
  if (s.outside.mode == OutsideMode::kFixed && s.outside != Outside{}) {
    return error::InvalidField("lattice.outside.mode", "a fixed one has no widths");
  }
  int64_t count = 1;
  for (size_t axis = 0; axis < 3; ++axis) {
    LATTICED_RETURN_IF_ERROR(CheckSide(s, axis, false));
    LATTICED_RETURN_IF_ERROR(CheckSide(s, axis, true));
    count *= s.size[axis] + AddedBy(s, axis, false) + AddedBy(s, axis, true);
  }
  if (count > limits::kMaxControlPoints) {
    return error::InvalidField(
        "lattice.outside",
        fmt::format("continues the lattice with {} control points, at most {} are allowed", count,
                    limits::kMaxControlPoints),
        "OUT_OF_RANGE");
  }
  return absl::OkStatus();
}

Outside ResolvedOutside(const LatticeStructure& s, std::span<const Vec3d> mesh) {
  Outside outside = s.outside;
  const auto is_fixed = [&] {
    return std::ranges::all_of(outside.widths, [](double w) { return w == 0; });
  };
  if (outside.mode == OutsideMode::kLinear && is_fixed()) {
    // What lies within rounding of a face is no reason to continue the lattice there.
    constexpr double kMore = 1.0 / 16, kNothing = 1e-9;
    outside.widths = ReachOf(s, mesh);
    for (double& width : outside.widths) {
      width = width > kNothing ? std::max((1 + kMore) * width, kLeastOutsideWidth) : 0;
    }
  }
  if (outside.mode == OutsideMode::kFixed || is_fixed()) return {};
  if (outside.mode == OutsideMode::kLinear) {
    outside.smooth = true;
    outside.steps = {};
    return outside;
  }
  for (size_t side = 0; side < 6; ++side) {
    double& step = outside.steps[side];
    const double width = outside.widths[side];
    if (width == 0) step = 0;
    if (width == 0 || step != 0) continue;
    step = std::min(width / 2, EndSpan(s, side / 2, side % 2 == 1) / 4);
  }
  return outside;
}

}  // namespace latticed

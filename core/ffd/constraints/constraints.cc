// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/constraints/constraints.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/edit/knot_insertion.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr double kOrthogonal = 1e-12;  // sine between two edges, at most

absl::Status CheckHeld(const std::vector<uint32_t>& held, const LatticeStructure& structure,
                       std::string_view field) {
  const auto count = static_cast<size_t>(structure.control_point_count());
  std::vector<bool> seen(count);
  for (size_t n = 0; n < held.size(); ++n) {
    const std::string path = fmt::format("{}.held[{}]", field, n);
    if (held[n] >= count) {
      return error::OutOfRange(path, held[n], 0, static_cast<double>(count) - 1);
    }
    if (seen[held[n]]) {
      return error::InvalidField(path, fmt::format("control point {} is named twice", held[n]));
    }
    seen[held[n]] = true;
  }
  return absl::OkStatus();
}

absl::Status CheckLayers(const std::vector<HeldLayers>& all, const LatticeStructure& structure,
                         std::string_view field) {
  for (size_t n = 0; n < all.size(); ++n) {
    const HeldLayers& layers = all[n];
    const std::string path = fmt::format("{}.held_layers[{}]", field, n);
    LATTICED_RETURN_IF_ERROR(error::CheckRange(path + ".axis", layers.axis, 0, 2));
    const int most = std::min(kMostHeldLayers, structure.size[static_cast<size_t>(layers.axis)]);
    LATTICED_RETURN_IF_ERROR(error::CheckRange(path + ".layers", layers.layers, 1, most));
    for (size_t m = 0; m < n; ++m) {
      if (all[m].axis == layers.axis && all[m].at_end == layers.at_end) {
        return error::InvalidField(path, "names the same face as an earlier one");
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckMirror(int axis, const LatticeStructure& structure, std::string_view field) {
  const std::string path = fmt::format("{}.mirror", field);
  LATTICED_RETURN_IF_ERROR(error::CheckRange(path, axis, 0, 2));
  const auto a = static_cast<size_t>(axis);
  const auto& knots = structure.knots[a];
  const double sum = knots.front() + knots.back();
  const double range = structure.domain_end(axis) - structure.domain_begin(axis);
  for (size_t i = 0; i < knots.size(); ++i) {
    if (std::abs(knots[i] + knots[knots.size() - 1 - i] - sum) > kSameKnot * range) {
      return error::InvalidField(path, "the knots of this axis are not symmetric");
    }
  }
  const Outside& outside = structure.outside;
  const size_t begin = SideOf(a, false), end = SideOf(a, true);
  if (outside.widths[begin] != outside.widths[end] ||
      std::abs(outside.steps[begin] - outside.steps[end]) > kSameKnot) {
    return error::InvalidField(path, "what goes on outside the two faces is not symmetric");
  }
  const auto& edges = structure.frame.edges;
  for (size_t other = 0; other < 3; ++other) {
    const double sine =
        std::abs(Dot(edges[a], edges[other])) / (Norm(edges[a]) * Norm(edges[other]));
    if (other != a && sine > kOrthogonal) {
      return error::InvalidField(path, "the axis is not orthogonal to the frame's other edges");
    }
  }
  return absl::OkStatus();
}

// The held control points after one insertion.
std::vector<uint32_t> HeldAfter(const std::vector<uint32_t>& held, const LatticeStructure& before,
                                size_t axis, double value) {
  const std::vector<double> weights = InsertionWeights(before, static_cast<int>(axis), value);
  std::vector<bool> was(static_cast<size_t>(before.control_point_count()));
  for (const uint32_t index : held) was[index] = true;
  LatticeStructure after = before;  // for its size
  ++after.size[axis];
  std::vector<uint32_t> result;
  for (int k = 0; k < after.size[2]; ++k) {
    for (int j = 0; j < after.size[1]; ++j) {
      for (int i = 0; i < after.size[0]; ++i) {
        std::array<int, 3> upper{i, j, k}, lower{i, j, k};
        --lower[axis];
        const double weight = weights[static_cast<size_t>(upper[axis])];
        const auto at = [&](const std::array<int, 3>& p) {
          return was[static_cast<size_t>(before.Index(p[0], p[1], p[2]))];
        };
        if ((weight != 0 && at(upper)) || (weight != 1 && at(lower))) {
          result.push_back(static_cast<uint32_t>(after.Index(i, j, k)));
        }
      }
    }
  }
  return result;
}

}  // namespace

absl::Status Check(const KeptVolume& kept, std::string_view field) {
  if (kept.axis.has_value()) {
    LATTICED_RETURN_IF_ERROR(error::CheckRange(fmt::format("{}.axis", field), *kept.axis, 0, 2));
  }
  const std::string path = fmt::format("{}.volume", field);
  if (kept.volume.has_value() && !std::isfinite(*kept.volume)) return error::NotFinite(path);
  if (kept.volume == 0) return error::InvalidField(path, "must not be 0");
  return absl::OkStatus();
}

absl::Status Check(const Constraints& constraints, const LatticeStructure& structure,
                   std::string_view field) {
  LATTICED_RETURN_IF_ERROR(CheckHeld(constraints.held, structure, field));
  LATTICED_RETURN_IF_ERROR(CheckLayers(constraints.held_layers, structure, field));
  if (constraints.mirror.has_value()) {
    LATTICED_RETURN_IF_ERROR(CheckMirror(*constraints.mirror, structure, field));
  }
  if (!constraints.volume.has_value()) return absl::OkStatus();
  return Check(*constraints.volume, fmt::format("{}.volume", field));
}

Constraints AfterInsertion(const Constraints& constraints, const LatticeStructure& before,
                           const LatticeStructure& after) {
  Constraints result = constraints;
  if (constraints.held.empty()) return result;
  LatticeStructure present = before;
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> added;
    std::ranges::set_difference(after.knots[axis], before.knots[axis], std::back_inserter(added));
    for (const double knot : added) {
      result.held = HeldAfter(result.held, present, axis, knot);
      auto& knots = present.knots[axis];
      knots.insert(std::ranges::upper_bound(knots, knot), knot);
      ++present.size[axis];
    }
  }
  return result;
}

bool HaveSameNet(const LatticeStructure& a, const LatticeStructure& b) {
  return a.degree == b.degree && a.size == b.size && a.knots == b.knots;
}

Constraints AfterReplacement(const Constraints& constraints, const LatticeStructure& before,
                             const LatticeStructure& after) {
  Constraints result = constraints;
  if (!HaveSameNet(before, after)) result.held.clear();
  for (HeldLayers& layers : result.held_layers) {
    layers.layers = std::min(layers.layers, after.size[static_cast<size_t>(layers.axis)]);
  }
  if (result.mirror.has_value() && !CheckMirror(*result.mirror, after, "").ok()) {
    result.mirror.reset();
  }
  return result;
}

std::optional<double> MirroredKnot(const LatticeStructure& structure, int axis, double value) {
  const double begin = structure.domain_begin(axis), end = structure.domain_end(axis);
  const double mirrored = begin + (end - value);
  if (std::abs(mirrored - value) <= kSameKnot * (end - begin)) return std::nullopt;
  return mirrored;
}

}  // namespace latticed

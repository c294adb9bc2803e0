// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/edit/knot_insertion.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/bspline_basis.h"
#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/outside/outside_rules.h"
#include "fmt/format.h"

namespace latticed {
namespace {

absl::Status Check(const LatticeStructure& s, int axis, double value, std::string_view field) {
  LATTICED_RETURN_IF_ERROR(error::CheckRange(fmt::format("{}.axis", field), axis, 0, 2));
  const std::string path = fmt::format("{}.value", field);
  if (!std::isfinite(value)) return error::NotFinite(path);
  if (value <= s.domain_begin(axis) || value >= s.domain_end(axis)) {
    return error::InvalidField(path,
                               fmt::format("got {}, allowed is strictly between {} and {}", value,
                                           s.domain_begin(axis), s.domain_end(axis)),
                               "OUT_OF_RANGE");
  }
  const auto a = static_cast<size_t>(axis);
  const auto there = std::count(s.knots[a].begin(), s.knots[a].end(), value);
  if (there >= s.degree[a]) {
    return error::InvalidField(
        path, fmt::format("knot {} already has multiplicity {}; degree {} allows no more", value,
                          there, s.degree[a]));
  }
  const int layer = s.control_point_count() / s.size[a];
  if (s.control_point_count() + layer > limits::kMaxControlPoints) {
    return error::InvalidField(
        field,
        fmt::format("would make {} control points, at most {} are allowed",
                    s.control_point_count() + layer, limits::kMaxControlPoints),
        "OUT_OF_RANGE");
  }
  return absl::OkStatus();
}

}  // namespace

std::vector<double> InsertionWeights(const LatticeStructure& s, int axis, double value) {
  const auto a = static_cast<size_t>(axis);
  const int degree = s.degree[a];
  const auto& knots = s.knots[a];
  const int span = FindLowerSpan(knots.data(), degree, s.size[a], value);
  std::vector<double> weights(static_cast<size_t>(s.size[a]) + 1);
  for (int i = 0; i <= s.size[a]; ++i) {
    const auto n = static_cast<size_t>(i);
    if (i <= span - degree) {
      weights[n] = 1;
    } else if (i > span) {
      weights[n] = 0;
    } else {
      const double begin = knots[n], end = knots[n + static_cast<size_t>(degree)];
      weights[n] = (value - begin) / (end - begin);
    }
  }
  return weights;
}

absl::StatusOr<Lattice> WithKnotInserted(const Lattice& lattice, int axis, double value,
                                         std::string_view field) {
  const LatticeStructure& s = lattice.structure;
  LATTICED_RETURN_IF_ERROR(Check(s, axis, value, field));
  const auto a = static_cast<size_t>(axis);
  const std::vector<double> weights = InsertionWeights(s, axis, value);

  Lattice result{s, {}};
  auto& knots = result.structure.knots[a];
  knots.insert(std::upper_bound(knots.begin(), knots.end(), value), value);
  ++result.structure.size[a];
  if (const auto status = ValidateOutside(result.structure); !status.ok()) {
    return error::InvalidField(std::string(field), std::string(status.message()), "OUT_OF_RANGE");
  }
  // Cannot fail on a valid lattice, but nothing invalid may enter a scene.
  LATTICED_RETURN_IF_ERROR(Validate(result.structure));

  const std::vector<Vec3d> old_identity = IdentityControlPoints(s);
  const std::vector<Vec3d> new_identity = IdentityControlPoints(result.structure);
  const auto& old = lattice.control_points;
  const auto at_rest = [&](size_t i) { return SameBits(old[i], old_identity[i]); };
  const std::array<size_t, 3> steps{1, static_cast<size_t>(s.size[0]),
                                    static_cast<size_t>(s.size[0] * s.size[1])};
  // `upper` is the old index of P_i; P_{i-1} lies one step before it.
  const auto point = [&](size_t upper, double weight) {
    const size_t lower = upper - steps[a];
    const bool uses_upper = weight != 0, uses_lower = weight != 1;
    if ((!uses_upper || at_rest(upper)) && (!uses_lower || at_rest(lower))) {
      return new_identity[result.control_points.size()];
    }
    if (!uses_lower) return old[upper];
    if (!uses_upper) return old[lower];
    return (1 - weight) * old[lower] + weight * old[upper];
  };
  const auto& size = result.structure.size;
  result.control_points.reserve(new_identity.size());
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const int along = axis == 0 ? i : axis == 1 ? j : k;
        result.control_points.push_back(
            point(static_cast<size_t>(s.Index(i, j, k)), weights[static_cast<size_t>(along)]));
      }
    }
  }
  return result;
}

absl::StatusOr<Lattice> WithKnotsOf(const Lattice& lattice, const LatticeStructure& structure) {
  Lattice refined = lattice;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    std::vector<double> missing;
    std::set_difference(structure.knots[a].begin(), structure.knots[a].end(),
                        lattice.structure.knots[a].begin(), lattice.structure.knots[a].end(),
                        std::back_inserter(missing));
    for (const double knot : missing) {
      LATTICED_ASSIGN_OR_RETURN(refined, WithKnotInserted(refined, axis, knot, "knot"));
    }
  }
  return refined;
}

}  // namespace latticed

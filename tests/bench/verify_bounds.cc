// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/verify_bounds.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "core/adaptive/adaptive_reference.h"
#include "core/patches/edge_bound.h"
#include "fmt/format.h"

namespace latticed::bench {
namespace {

// Of the mesh's diagonal. In the scenarios of 17,119 and 113,663 patches, what stands for rounding is at most 0.2 of such
// a bound. Twice that is less than a step, which is a factor of sqrt(2). 92 % of the edges bend as much.
constexpr double kBent = 1e-5;

// By number of the edge.
std::vector<uint8_t> EdgeBytes(const Scenario& scenario, DeformView& view) {
  CheckOk(view.Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  std::vector<uint8_t> bytes;
  for (const SharedBytes& chunk : Checked(view.Encode(scenario.all_chunks, Encoding::kPatches))) {
    bytes.insert(bytes.end(), chunk.span().begin(), chunk.span().end());
  }
  return bytes;
}

// The largest bound along each edge in its patches.
std::vector<double> DefinedBounds(const Scenario& scenario) {
  const auto bounds = AdaptiveReference(scenario.plan).Bounds(scenario.control_points[0]);
  std::vector<double> largest(scenario.plan->edges.size());
  for (size_t p = 0; p < bounds.size(); ++p) {
    for (size_t e = 0; e < 3; ++e) {
      double& edge = largest[scenario.plan->patches[p].edge[e]];
      edge = std::max(edge, bounds[p].edge[e]);
    }
  }
  return largest;
}

}  // namespace

absl::Status VerifyBounds(const Scenario& scenario, DeformView& view) {
  const auto bytes = EdgeBytes(scenario, view);
  const auto on_cpu = EdgeBytes(scenario, *MakeView(scenario, Pipeline::kFused, view.spec(), 1));
  const auto defined = DefinedBounds(scenario);
  if (bytes.size() != defined.size() || on_cpu.size() != defined.size()) {
    return absl::InternalError(fmt::format("{} bytes, and {} on the CPU, for {} edges",
                                           bytes.size(), on_cpu.size(), defined.size()));
  }
  const double unit = CurvatureUnit(scenario.plan->mesh_bounds);
  const double bent = kBent * scenario.plan->mesh_bounds.diagonal();
  for (size_t e = 0; e < bytes.size(); ++e) {
    const bool holds = EdgeBound(std::min(bytes[e], on_cpu[e]), unit) >= defined[e];
    if (holds && (defined[e] < bent || std::abs(bytes[e] - on_cpu[e]) <= 1)) continue;
    return absl::InternalError(
        fmt::format("edge {} has byte {}, and {} on the CPU; its bound is {}", e, bytes[e],
                    on_cpu[e], defined[e]));
  }
  return absl::OkStatus();
}

}  // namespace latticed::bench

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/exports/control_nets.h"

#include <algorithm>

#include "core/backend.h"
#include "core/base/status_macros.h"

namespace latticed {
namespace {

// The number of patches whose control nets one call computes: enough to keep the backend busy. Cancellation is
// checked between the calls.
constexpr size_t kNetBlock = 4096;

template <typename T>
void AppendBytes(const T& value, std::string& out) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

absl::StatusOr<std::string> WriteControlNets(const RenderInput& input, StopCheck stop) {
  const SceneState& state = *input.state;
  const DeformPlan& plan = *state.plan;
  LATTICED_ASSIGN_OR_RETURN(const auto target, input.target->Get());
  const auto n = static_cast<uint32_t>(plan.surface_degree());
  const uint32_t m = (n + 1) * (n + 2) / 2;
  std::string out("LATTNETS");
  AppendBytes(uint32_t{1}, out);
  AppendBytes(n, out);
  AppendBytes(m, out);
  AppendBytes(uint32_t{0}, out);
  AppendBytes(uint64_t{plan.patches.size()}, out);
  out.reserve(out.size() + plan.patches.size() * m * sizeof(Vec3d));
  for (size_t first = 0; first < plan.patches.size(); first += kNetBlock) {
    LATTICED_RETURN_IF_ERROR(stop());
    const size_t last = std::min(first + kNetBlock, plan.patches.size());
    LATTICED_ASSIGN_OR_RETURN(const auto nets, input.target->backend().Run([&] {
      return target->ControlNets(*state.control_points, first, last);
    }));
    out.append(reinterpret_cast<const char*>(nets.data()), nets.size() * sizeof(double));
  }
  return out;
}

uint64_t ControlNetsBytes(const DeformPlan& plan) {
  constexpr uint64_t kSmallBytes = uint64_t{128} << 10;
  const uint64_t patches = plan.patches.size();
  const auto n = static_cast<uint64_t>(plan.surface_degree());
  const uint64_t net_bytes = (n + 1) * (n + 2) / 2 * sizeof(Vec3d);
  return (patches + std::min<uint64_t>(patches, kNetBlock)) * net_bytes + kSmallBytes;
}

}  // namespace latticed

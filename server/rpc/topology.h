// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The answer of GetTopology: where each patch comes from, in parts that fit a message.
//
// Errors   none: the caller checks the range
// Threads  pure functions
#ifndef LATTICED_SERVER_RPC_TOPOLOGY_H_
#define LATTICED_SERVER_RPC_TOPOLOGY_H_

#include <cstddef>
#include <string>
#include <string_view>

#include "core/ffd/plan/deform_plan.h"
#include "latticed/v1/scene.pb.h"

namespace latticed {

// A patch takes at most 120 bytes (5 + 15 + 72 + 1 + 15 + 12), so a part stays below limits::kMaxPartBytes.
inline constexpr size_t kPatchesPerTopologyPart = 6144;

// Patches from `first` on, at most kPatchesPerTopologyPart of them.
[[nodiscard]] v1::TopologyPart MakeTopologyPart(const DeformPlan& plan, std::string topology_id,
                                                size_t first);

// Whether `topology_id` names this mesh and structure, with any segments or a tolerance.
[[nodiscard]] bool IsTopologyOf(std::string_view topology_id, std::string_view mesh_id,
                                const DeformPlan& plan);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_TOPOLOGY_H_

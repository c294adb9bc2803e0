// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/topology.h"

#include <algorithm>
#include <utility>

#include "core/base/limits.h"
#include "server/engine/scene/topology_id.h"

namespace latticed {
namespace {

static_assert(kPatchesPerTopologyPart * 120 < limits::kMaxPartBytes);

bool OnLatticeFace(const DeformPlan& plan, const Patch& patch) {
  const auto on_seam = [](const auto& element) { return element.seam != kNoIndex; };
  return std::ranges::any_of(patch.vertex, [&](uint32_t v) { return on_seam(plan.vertices[v]); }) ||
         std::ranges::any_of(patch.edge, [&](uint32_t e) { return on_seam(plan.edges[e]); });
}

}  // namespace

v1::TopologyPart MakeTopologyPart(const DeformPlan& plan, std::string topology_id, size_t first) {
  v1::TopologyPart part;
  part.set_topology_id(std::move(topology_id));
  part.set_patch_count(plan.patches.size());
  part.set_first_patch(first);
  const size_t last = std::min(first + kPatchesPerTopologyPart, plan.patches.size());
  for (size_t p = first; p < last; ++p) {
    const PatchSource& source = plan.sources[p];
    part.add_faces(source.face);
    for (const uint32_t corner : source.corners) {
      const uint32_t vertex = plan.mesh->corner_vertices[corner];
      part.add_corners(corner);
      part.add_vertices(vertex);
      if (plan.is_weighted()) part.add_weights((*plan.mesh_weights)[vertex]);
    }
    for (const auto& corner : source.barycentrics) {
      for (const double b : corner) part.add_barycentrics(b);
    }
    part.add_on_lattice_face(OnLatticeFace(plan, plan.patches[p]));
  }
  return part;
}

bool IsTopologyOf(std::string_view topology_id, std::string_view mesh_id, const DeformPlan& plan) {
  for (int s = 0; s <= limits::kMaxSegments; ++s) {
    if (topology_id == TopologyId(mesh_id, plan, s)) return true;
  }
  return false;
}

}  // namespace latticed

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/pack_shared_points.h"

#include <algorithm>
#include <utility>

#include "core/base/limits.h"
#include "core/ffd/plan/shared_points.h"

namespace latticed {
namespace {

using kernels::DeviceCopy;
using kernels::DeviceOrphan;
using kernels::kSharedRun;
using kernels::PackedUse;
using kernels::PackUse;

static_assert(limits::kMaxPatches < (uint64_t{1} << 28), "a packed use has 28 bits for the patch");

DeviceCopy Pack(const SharedCopy& copy) {
  return {PackUse(copy.from_patch, copy.from_slot, copy.reversed),
          PackUse(copy.to_patch, copy.to_slot, false)};
}

DeviceOrphan Pack(const DeformPlan& plan, const SharedPoints::Orphan& orphan) {
  DeviceOrphan packed{.use = PackUse(orphan.use.patch, orphan.use.slot, orphan.use.reversed),
                      .box = 0,
                      .vertex = {orphan.entity, orphan.entity},
                      .seam = orphan.seam};
  if (orphan.use.slot < kFirstEdgeSlot) {
    packed.box = plan.vertices[orphan.entity].box;
    return packed;
  }
  const PlanEdge& edge = plan.edges[orphan.entity];
  packed.box = edge.box;
  packed.vertex[0] = edge.vertex[0];
  packed.vertex[1] = edge.vertex[1];
  return packed;
}

void PackEdges(std::vector<SharedCopy> edges, size_t patches, PackedSharedPoints& packed) {
  std::sort(edges.begin(), edges.end(), [](const SharedCopy& a, const SharedCopy& b) {
    return std::pair(a.to_patch, a.to_slot) < std::pair(b.to_patch, b.to_slot);
  });
  packed.edge_begins.assign((patches + kSharedRun - 1) / kSharedRun + 1, 0);
  for (const SharedCopy& copy : edges) {
    ++packed.edge_begins[copy.to_patch / kSharedRun + 1];
    packed.edge_owners.push_back(Pack(copy).from);
    const uint32_t edge = uint32_t{copy.to_slot} - kFirstEdgeSlot;
    packed.edge_uses.push_back(static_cast<uint8_t>(copy.to_patch % kSharedRun | edge << 5));
  }
  for (size_t r = 1; r < packed.edge_begins.size(); ++r) {
    packed.edge_begins[r] += packed.edge_begins[r - 1];
  }
}

}  // namespace

PackedSharedPoints PackSharedPoints(const DeformPlan& plan) {
  const SharedPoints shared(plan);
  PackedSharedPoints packed;
  packed.vertex_owners.assign(plan.vertices.size(), kernels::kNoUse);
  std::vector<SharedCopy> edges;
  for (const SharedCopy& copy : shared.always()) {
    if (copy.to_slot >= kFirstEdgeSlot) {
      edges.push_back(copy);
    } else {
      packed.vertex_owners[plan.patches[copy.to_patch].vertex[copy.to_slot]] = Pack(copy).from;
    }
  }
  PackEdges(std::move(edges), plan.patches.size(), packed);
  for (const auto& [seam, copy] : shared.when_attached()) {
    packed.on_seams.push_back({Pack(copy), seam << 1 | 1});
  }
  for (const auto& [seam, copy] : shared.when_detached()) {
    packed.on_seams.push_back({Pack(copy), seam << 1});
  }
  for (const auto& orphan : shared.orphans()) packed.orphans.push_back(Pack(plan, orphan));
  return packed;
}

}  // namespace latticed

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/pack_patches.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/ffd/plan/shared_points.h"
#include "cuda/plan/plan_tables.h"

namespace latticed {
namespace {

using kernels::DevicePatch;
using kernels::SeamUse;

static_assert(limits::kMaxPatches < (uint64_t{1} << 29), "a seam use's key has 29 bits for it");
static_assert(limits::kMaxControlPoints < kernels::kDeviceBoxes, "a lattice has fewer boxes");

class Packer {
 public:
  explicit Packer(const DeformPlan& plan)
      : plan_(plan), strides_(BoxStrides(plan.structure)), outside_(plan.outside_box()) {}

  PackedPatches Run() {
    result_.patches.reserve(plan_.patches.size());
    for (uint32_t p = 0; p < plan_.patches.size(); ++p) Pack(p);
    return std::move(result_);
  }

 private:
  void Pack(uint32_t p) {
    const Patch& patch = plan_.patches[p];
    DevicePatch packed{};
    packed.word[3] = patch.box;
    for (uint32_t c = 0; c < 3; ++c) packed.word[c] = patch.vertex[c];
    // Patches outside take every point from the identity map, on a seam or not.
    if (patch.box != outside_) {
      for (uint32_t c = 0; c < 3; ++c) {
        const PlanVertex& corner = plan_.vertices[patch.vertex[c]];
        packed.word[3] |= Steps(patch.box, corner.box) << (20 + 3 * c);
        if (AddSeam(p, c, corner.seam)) packed.word[3] |= uint32_t{1} << (29 + c);
      }
      for (uint32_t e = 0; e < 3; ++e) {
        const PlanEdge& edge = plan_.edges[patch.edge[e]];
        packed.word[e] |= Steps(patch.box, edge.box) << 28;
        if (AddSeam(p, kFirstEdgeSlot + e, edge.seam)) packed.word[e] |= uint32_t{1} << 31;
      }
    }
    result_.patches.push_back(packed);
  }

  // The axes along which `owner` is the next lower box of `box`, as bits.
  uint32_t Steps(uint32_t box, uint32_t owner) const {
    uint32_t steps = 0, left = box - owner;
    for (uint32_t axis = 3; axis-- > 0;) {
      if (left < strides_[axis]) continue;
      left -= strides_[axis];
      steps |= uint32_t{1} << axis;
    }
    return steps;
  }

  // Returns whether the slot is on a seam. Patches and their slots come in ascending order.
  bool AddSeam(uint32_t patch, uint32_t slot, uint32_t seam) {
    if (seam == kNoIndex) return false;
    result_.seam_uses.push_back({patch * 8 + slot, seam});
    return true;
  }

  const DeformPlan& plan_;
  const std::array<uint32_t, 3> strides_;
  const uint32_t outside_;
  PackedPatches result_;
};

}  // namespace

std::array<uint32_t, 3> BoxStrides(const LatticeStructure& structure) {
  std::array<uint32_t, 3> strides{};
  uint32_t stride = 1;
  for (size_t axis = 0; axis < 3; ++axis) {
    strides[axis] = stride;
    const std::vector<double>& knots = structure.knots[axis];
    uint32_t boxes = 0;
    for (int i = structure.degree[axis]; i < structure.size[axis]; ++i) {
      const auto k = static_cast<size_t>(i);
      if (knots[k + 1] > knots[k]) ++boxes;
    }
    stride *= boxes;
  }
  return strides;
}

absl::StatusOr<PackedPatches> PackPatches(const DeformPlan& plan) {
  if (plan.vertices.size() > kernels::kDeviceVertices) {
    constexpr uint64_t kBytes = sizeof(kernels::DeviceVertex);
    return error::OutOfMemory("the plan's vertices on a device", plan.vertices.size() * kBytes,
                              kernels::kDeviceVertices * kBytes);
  }
  return Packer(plan).Run();
}

}  // namespace latticed

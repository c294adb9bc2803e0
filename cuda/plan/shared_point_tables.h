// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which positions a patch takes from another, for pipelines that evaluate every patch by itself.
//                                                                     core/ffd/plan/shared_points.h
// Threads  plain data, host and device
#ifndef LATTICED_CUDA_PLAN_SHARED_POINT_TABLES_H_
#define LATTICED_CUDA_PLAN_SHARED_POINT_TABLES_H_

#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"

namespace latticed::kernels {

// A corner (slot 0..2) or an edge (slot 3..5) of a patch: patch << 4 | slot << 1 | reversed.
using PackedUse = uint32_t;
LATTICED_HD constexpr PackedUse PackUse(uint32_t patch, uint32_t slot, bool reversed) {
  return patch << 4 | slot << 1 | static_cast<uint32_t>(reversed);
}
inline constexpr PackedUse kNoUse = ~uint32_t{0};

// The corner or the inner points of the edge that `to` takes from `from`, which is reversed where it
// runs against `to`.
struct DeviceCopy {
  PackedUse from, to;
};
struct DeviceSeamCopy {
  DeviceCopy copy;
  uint32_t seam;  // seam << 1 | when attached
};
// Points evaluated from the lattice: at vertex[0], or along the edge between both, in canonical order.
struct DeviceOrphan {
  PackedUse use;
  uint32_t box;
  uint32_t vertex[2];
  uint32_t seam;  // only while this one is detached; all bits set: always
};

// The patches of a run; their copies of edges are stored together.
inline constexpr uint32_t kSharedRun = 32;

struct SharedPointTables {
  size_t patch_count;
  // One for each vertex of the plan; kNoUse when nothing is copied, or not always.
  const PackedUse* vertex_owners;
  // Copies edge_begins[r] .. edge_begins[r + 1] - 1 are those of run r: each from edge_owners[i],
  // reversed as in DeviceCopy, to edge_uses[i] = patch in the run | edge << 5.
  const uint32_t* edge_begins;
  const PackedUse* edge_owners;
  const uint8_t* edge_uses;
  const DeviceSeamCopy* on_seams;
  size_t on_seams_count;
  const DeviceOrphan* orphans;
  size_t orphan_count;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_SHARED_POINT_TABLES_H_

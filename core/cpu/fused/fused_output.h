// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Stores the fused kernel's groups of 16 patches in a view's vertices.
//
//   kQuantised  the planes x y z s t of each chunk (backend.h); x y z in 2 bytes, s t in 1 or 2
//   kFloat32    point after point, or in lane order [group][point][component][16 lanes]
//
// Threads  groups may be stored by several threads at once; they share no byte
#ifndef LATTICED_CORE_CPU_FUSED_FUSED_OUTPUT_H_
#define LATTICED_CORE_CPU_FUSED_FUSED_OUTPUT_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/backend.h"
#include "core/cpu/fused/cpu_fused.h"
#include "core/cpu/fused/fused_layout.h"
#include "core/cpu/fused/kernel/fused_kernel.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/plan/quantisation_box.h"

namespace latticed::fused {

// Stores the vertices of one Evaluate. The plan, the layout, the spec and the vertices must outlive it.
class FusedOutput {
 public:
  FusedOutput(const DeformPlan& plan, const FusedLayout& layout, const QuantisationBox& box,
              const ViewSpec& spec, FusedOrder order, std::span<uint8_t> vertices);

  // Prefetches the cache lines that Store will write for the group, kQuantised only. Call it before the evaluation.
  void Prefetch(const Group& group) const;
  // `scratch` holds x y z, and then the normal if the view has normals.
  void Store(uint32_t group, const GroupScratch& scratch) const;

 private:
  // The values of one patch in a plane of its chunk. The next patch's values begin `stride` bytes later.
  struct Plane {
    uint8_t* bytes;
    size_t stride;
  };
  template <class F>
  void ForRuns(const Group& group, const F& f) const;
  std::array<Plane, 5> PatchPlanes(size_t patch) const;
  void StoreInPlanes(const Group& group, const GroupScratch& scratch) const;
  void StoreByPoint(const Group& group, const GroupScratch& scratch) const;

  const DeformPlan& plan_;
  const FusedLayout& layout_;
  const ViewSpec& spec_;
  const FusedOrder order_;
  const std::span<uint8_t> vertices_;
  std::array<float, 3> scale_, offset_;  // integer = round(p * scale + offset)
};

// The size of a whole view in lane order, kFloat32.
[[nodiscard]] size_t LaneOrderBytes(const FusedLayout& layout, const ViewSpec& spec);
// Copies one chunk of lane-ordered vertices to `out`, in wire layout.
void ReadLaneOrder(const DeformPlan& plan, const FusedLayout& layout, const ViewSpec& spec,
                   std::span<const uint8_t> vertices, uint32_t chunk, std::span<uint8_t> out);

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_FUSED_FUSED_OUTPUT_H_

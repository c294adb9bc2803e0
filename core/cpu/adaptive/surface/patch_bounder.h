// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds of the second derivatives of patches on the CPU, 16 patches at a time (kernel/adaptive_bounds-inl.h). Patches
// outside the frame are skipped: they do not bend. Patches with vertex weights are bounded one at a time, in double
// (core/adaptive/adaptive_reference.h); this takes 3 us a patch of degree 2 x 2 x 2, and
// 8 us at 3 x 3 x 3.
//
// Threads  one thread at a time; uses those of the arena
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_PATCH_BOUNDER_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_PATCH_BOUNDER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/adaptive/adaptive_reference.h"
#include "core/cpu/adaptive/surface/adaptive_surface.h"
#include "core/cpu/adaptive/surface/frame_boxes.h"
#include "core/cpu/fused/fused_plan.h"
#include "core/view/cpu_arena.h"

namespace latticed {

class PatchBounder {
 public:
  using Take = AdaptiveSurface::Take;

  // Keeps a reference to the arena.
  PatchBounder(std::shared_ptr<const fused::FusedPlan> plan, CpuArena& arena);

  // Bounds the patches of `chunks`, and those that share a group of 16 with them. Makes the boxes that this needs.
  void Bound(std::span<const uint32_t> chunks, std::span<const Vec3d> control_points,
             fused::FrameBoxes& boxes, Take take) const;

  // By box: what the slack of bounds needs.
  std::span<Vec3d> reach() { return reach_; }
  size_t MemoryBytes() const { return reach_.size() * sizeof(Vec3d); }

 private:
  void MeasureReach();
  void BoundWeighted(std::span<const uint32_t> groups, std::span<const Vec3d> control_points,
                     Take take) const;
  // Their boxes are needed then.
  std::vector<uint32_t> GroupsOf(std::span<const uint32_t> chunks, fused::FrameBoxes& boxes) const;

  const std::shared_ptr<const fused::FusedPlan> plan_;
  CpuArena& arena_;
  std::vector<Vec3d> reach_;
  std::optional<AdaptiveReference> weighted_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_PATCH_BOUNDER_H_

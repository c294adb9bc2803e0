// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused pipeline under a tolerance: bounds of 16 patches at a time (patch_bounder.h), and points of a box side by
// side (adaptive_points.h). Both take the polynomials of boxes, made once an evaluation.
//
// Errors   none
// Threads  those of adaptive_surface.h
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FUSED_SURFACE_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FUSED_SURFACE_H_

#include <memory>
#include <optional>
#include <span>

#include "core/cpu/adaptive/surface/adaptive_surface.h"
#include "core/cpu/adaptive/surface/frame_boxes.h"
#include "core/cpu/adaptive/surface/patch_bounder.h"
#include "core/cpu/fused/fused_plan.h"
#include "core/view/cpu_arena.h"

namespace latticed {

class FusedSurface : public AdaptiveSurface {
 public:
  // Keeps a reference to the arena.
  FusedSurface(std::shared_ptr<const fused::FusedPlan> plan, const ViewSpec& spec, CpuArena& arena)
      : plan_(std::move(plan)), spec_(spec), arena_(arena), bounder_(plan_, arena) {}

  void Begin(std::span<const Vec3d> control_points) override;
  absl::Status Bound(std::span<const uint32_t> chunks, Take take) override;
  absl::Status Write(std::span<const uint32_t> chunks, std::span<const uint16_t> codes,
                     const QuantisationBox& box, ChunkVertices& vertices) override;
  std::span<Vec3d> reach() override { return bounder_.reach(); }
  size_t MemoryBytes() const override { return bounder_.MemoryBytes(); }

 private:
  const std::shared_ptr<const fused::FusedPlan> plan_;
  const ViewSpec spec_;
  CpuArena& arena_;
  PatchBounder bounder_;
  // Of the evaluation that runs.
  std::span<const Vec3d> control_points_;
  std::optional<fused::FrameBoxes> boxes_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FUSED_SURFACE_H_

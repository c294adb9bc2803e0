// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view with a tolerance, on the CPU. An evaluation of some chunks:
//
//   bounds    of the second derivatives of their patches (adaptive_surface.h)
//   levels    of their edges, and the patterns of all patches at edges whose levels changed (level_table.h)
//   points    of the chunks and of those whose patterns changed
//
// The tolerance is doubled until the view has at most as many points as spec.segments would give (ToleranceSteps of
// core/adaptive/edge_levels.h).
//
// Errors   those of the surface
// Threads  one thread at a time; uses those of the arena
#ifndef LATTICED_CORE_CPU_ADAPTIVE_ADAPTIVE_EVALUATOR_H_
#define LATTICED_CORE_CPU_ADAPTIVE_ADAPTIVE_EVALUATOR_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/backend.h"
#include "core/cpu/adaptive/level_table.h"
#include "core/cpu/adaptive/surface/adaptive_surface.h"
#include "core/cpu/adaptive/surface/chunk_vertices.h"
#include "core/view/cpu_arena.h"

namespace latticed {

class AdaptiveEvaluator {
 public:
  // spec.tolerance is above 0. Keeps a reference to the arena.
  AdaptiveEvaluator(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                    std::unique_ptr<AdaptiveSurface> surface, CpuArena& arena);

  // Writes the vertices of `chunks` and of those that also changed. The first call, and one with another box, names all.
  [[nodiscard]] absl::Status Evaluate(std::span<const Vec3d> control_points,
                                      const QuantisationBox& box, std::span<const uint32_t> chunks,
                                      ChunkVertices& vertices);

  // The steps of Evaluate, as those of core/view/spanned/tolerance_slice.h. The spans stay valid until Finish.
  [[nodiscard]] absl::Status Bound(std::span<const Vec3d> control_points,
                                   const QuantisationBox& box, std::span<const uint32_t> chunks);
  void Choose(double curvature_tolerance);
  [[nodiscard]] absl::Status Finish(ChunkVertices& vertices);

  // As AdaptiveSurface's. A slice gets that of all slices before its first evaluation.
  std::span<Vec3d> reach() { return surface_->reach(); }
  LevelTable& levels() { return levels_; }
  // Of the evaluation that runs.
  const QuantisationBox& box() const { return frame_->box; }

  // As DeformView's, after Evaluate.
  std::span<const uint32_t> also_changed() const { return also_changed_; }
  PatternCodes Patterns() const;
  double certified_error() const { return certified_error_; }
  double curvature_tolerance() const { return curvature_tolerance_; }

  size_t MemoryBytes() const;

 private:
  // The evaluation that runs.
  struct Frame {
    QuantisationBox box;
    std::span<const uint32_t> chunks;
    std::vector<uint32_t> changed;  // the chunks whose patterns changed
  };

  const ViewSpec spec_;
  CpuArena& arena_;
  const uint64_t most_points_;
  const std::unique_ptr<AdaptiveSurface> surface_;
  LevelTable levels_;
  double curvature_tolerance_ = 0;  // of the last Choose
  std::vector<uint32_t> all_chunks_;
  std::optional<Frame> frame_;
  std::vector<uint32_t> also_changed_;
  double certified_error_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_ADAPTIVE_EVALUATOR_H_

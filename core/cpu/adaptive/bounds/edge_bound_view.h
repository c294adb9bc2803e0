// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of bounds alone on the CPU: one byte per edge, and no vertices.
//
// Errors   those of core/view/checked_view.h
// Threads  one thread at a time; Evaluate uses the backend's arena and returns when done
#ifndef LATTICED_CORE_CPU_ADAPTIVE_BOUNDS_EDGE_BOUND_VIEW_H_
#define LATTICED_CORE_CPU_ADAPTIVE_BOUNDS_EDGE_BOUND_VIEW_H_

#include <memory>
#include <vector>

#include "core/cpu/adaptive/bounds/edge_bound_table.h"
#include "core/cpu/adaptive/surface/patch_bounder.h"
#include "core/cpu/cpu_context.h"
#include "core/view/checked_view.h"
#include "core/view/spanned/reach_slice.h"

namespace latticed {

class EdgeBoundView : public CheckedView, public ReachSlice {
 public:
  EdgeBoundView(std::shared_ptr<const fused::FusedPlan> plan, const ViewSpec& spec,
                std::shared_ptr<CpuContext> context);

  std::span<const uint32_t> also_changed() const override { return also_changed_; }
  MemoryUse memory() const override;
  ReachSlice* reach_slice() override { return this; }

  absl::StatusOr<std::vector<Vec3d>> BoxReach() override;
  absl::Status SetReach(std::span<const Vec3d> reach) override;

  // The most host memory that a view takes.
  static uint64_t MostBytes(const DeformPlan& plan);

 private:
  absl::Status EvaluateChunks(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) override;
  absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) override;
  size_t SizeOf(uint32_t chunk) const override { return bytes_.Size(chunk); }
  absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results,
                            TakeEarly early) override;

  const std::shared_ptr<const fused::FusedPlan> fused_plan_;
  const std::shared_ptr<CpuContext> context_;
  PatchBounder bounder_;
  EdgeBoundTable bytes_;
  std::vector<uint32_t> also_changed_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_BOUNDS_EDGE_BOUND_VIEW_H_

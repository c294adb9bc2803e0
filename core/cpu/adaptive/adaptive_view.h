// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view with a tolerance on the CPU. Its chunks have different numbers of points, which change with edits.
//
// Errors   those of core/view/checked_view.h, of the surface and of the encoder
// Threads  one thread at a time; Evaluate and Encode use the backend's arena and return when done
#ifndef LATTICED_CORE_CPU_ADAPTIVE_ADAPTIVE_VIEW_H_
#define LATTICED_CORE_CPU_ADAPTIVE_ADAPTIVE_VIEW_H_

#include <memory>

#include "core/cpu/adaptive/adaptive_evaluator.h"
#include "core/cpu/adaptive/surface/chunk_vertices.h"
#include "core/cpu/cpu_context.h"
#include "core/view/checked_view.h"
#include "core/view/spanned/tolerance_slice.h"
#include "core/view/view_encoder.h"

namespace latticed {

class AdaptiveView : public CheckedView, public ToleranceSlice {
 public:
  AdaptiveView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
               std::unique_ptr<AdaptiveSurface> surface, std::shared_ptr<CpuContext> context);

  std::span<const uint32_t> also_changed() const override { return evaluator_.also_changed(); }
  PatternCodes Patterns() const override { return evaluator_.Patterns(); }
  double certified_error() const override { return evaluator_.certified_error(); }
  double curvature_tolerance() const override { return evaluator_.curvature_tolerance(); }
  MemoryUse memory() const override;
  ToleranceSlice* tolerance_slice() override { return this; }

  absl::StatusOr<std::vector<Vec3d>> BoxReach() override;
  absl::Status SetReach(std::span<const Vec3d> reach) override;
  absl::Status ShareEdges(std::span<const uint32_t> edges) override;
  absl::Status Bound(std::span<const Vec3d> control_points, const QuantisationBox& box,
                     std::span<const uint32_t> chunks) override;
  absl::StatusOr<std::span<const float>> SharedBounds() override;
  absl::Status Choose(double curvature_tolerance, std::span<const float> shared_bounds) override;
  absl::StatusOr<uint64_t> CountPoints() override;
  absl::Status Finish() override;

  // The most host memory that a view takes.
  static uint64_t MostBytes(const DeformPlan& plan, const ViewSpec& spec);

 private:
  absl::Status EvaluateChunks(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) override;
  absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) override;
  absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results,
                            TakeEarly early) override;

  const std::shared_ptr<CpuContext> context_;
  AdaptiveEvaluator evaluator_;
  ChunkVertices vertices_;
  ViewEncoder encoder_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_ADAPTIVE_VIEW_H_

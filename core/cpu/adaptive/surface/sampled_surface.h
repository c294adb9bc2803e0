// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The matrix pipelines under a tolerance, in double. Bounds are those of control nets (core/adaptive/net_curvature.h), which
// are products of samples as in the pipelines. A pattern has fewer points than a net has samples, so points are not
// products but sums as the samples are (core/cpu/gemm/patch_sums.h).
//
// A corner, and a point of an edge, is the definition's in the box that owns it, on the way from one vertex to the other in
// canonical order (core/ffd/direct_ffd.h). All patches therefore have the same bits there.
//
// Errors   those of OpenBLAS
// Threads  those of adaptive_surface.h
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_SAMPLED_SURFACE_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_SAMPLED_SURFACE_H_

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/adaptive/adaptive_pattern.h"
#include "core/adaptive/net_slack.h"
#include "core/cpu/adaptive/surface/adaptive_surface.h"
#include "core/cpu/gemm/patch_sampler.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/stage_matrices.h"
#include "core/view/cpu_arena.h"
#include "core/view/vertex_layout.h"

namespace latticed {

class SampledSurface : public AdaptiveSurface {
 public:
  // stage: of surface_degree, any number of segments. Keeps references to it and to the arena.
  SampledSurface(std::shared_ptr<const DeformPlan> plan, const StageMatrices& stage,
                 const ViewSpec& spec, CpuArena& arena)
      : plan_(std::move(plan)), stage_(stage), spec_(spec), arena_(arena), slack_(*plan_) {}

  void Begin(std::span<const Vec3d> control_points) override;
  absl::Status Bound(std::span<const uint32_t> chunks, Take take) override;
  absl::Status Write(std::span<const uint32_t> chunks, std::span<const uint16_t> codes,
                     const QuantisationBox& box, ChunkVertices& vertices) override;
  size_t MemoryBytes() const override { return MostBytes(*plan_, arena_.most_threads()); }
  // The most host memory that an evaluation takes on so many threads.
  static uint64_t MostBytes(const DeformPlan& plan, size_t threads);

 private:
  struct Frame {
    Frame(const SampledSurface& surface, std::span<const Vec3d> control_points);

    PatchSampler sampler;
    DirectFfd direct;
    std::vector<bool> attached;  // by seam
    std::vector<double> norms;   // of control points, for slack_
  };
  // A patch that is written.
  struct Target {
    size_t patch;
    const AdaptivePattern& pattern;
    const VertexWriter& writer;
    PatchPlace place;
  };

  // Points of a patch that are evaluated together.
  struct OwnBlock {
    patch_sums::Places places;
    std::array<size_t, points::kBlockPoints> numbers;  // in the pattern
    patch_sums::Values values;
  };

  absl::Status BoundChunk(uint32_t chunk, Take take) const;
  void WriteChunk(uint32_t chunk, std::span<const uint16_t> codes, const VertexWriter& writer,
                  ChunkVertices& vertices) const;
  void WriteOwn(const Target& target) const;
  void WriteNormals(const Target& target, const OwnBlock& block) const;
  void WriteShared(const Target& target) const;
  // What a patch in `patch_box` has at a vertex or edge with this owner and seam, relative to the local origin.
  Vec3d Shared(uint32_t patch_box, uint32_t box, uint32_t seam, const std::array<uint32_t, 2>& ends,
               double t) const;

  const std::shared_ptr<const DeformPlan> plan_;
  const StageMatrices& stage_;
  const ViewSpec spec_;
  CpuArena& arena_;
  const NetSlack slack_;
  std::optional<Frame> frame_;  // of the evaluation that runs
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_SAMPLED_SURFACE_H_

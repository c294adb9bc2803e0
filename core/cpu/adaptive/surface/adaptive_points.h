// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The points of one evaluation of a view with a tolerance, on the CPU: those of the patches of one box and one chunk side by
// side, 16 at a time. A point on an edge or at a corner that another box owns is evaluated there (feature_points.h). An
// ill-conditioned normal is that of the definition in double.
//
// Threads  one thread at a time; uses those of the arena
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_ADAPTIVE_POINTS_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_ADAPTIVE_POINTS_H_

#include <cstdint>
#include <span>

#include "core/backend.h"
#include "core/cpu/adaptive/kernel/run_buffer.h"
#include "core/cpu/adaptive/surface/chunk_vertices.h"
#include "core/cpu/adaptive/surface/feature_points.h"
#include "core/cpu/adaptive/surface/frame_boxes.h"
#include "core/cpu/fused/fused_plan.h"
#include "core/view/cpu_arena.h"

namespace latticed {

class AdaptivePoints {
 public:
  // What is evaluated. `codes`: PatternKey::Code of each patch of the plan.
  struct Input {
    std::span<const Vec3d> control_points;
    const QuantisationBox& box;
    std::span<const uint16_t> codes;
  };

  // Keeps references to all.
  AdaptivePoints(const fused::FusedPlan& plan, const ViewSpec& spec, const Input& input,
                 fused::FrameBoxes& boxes)
      : plan_(plan),
        spec_(spec),
        input_(input),
        boxes_(boxes),
        features_(plan, input.control_points, boxes) {}

  // Writes the vertices of `chunks`.
  void Evaluate(std::span<const uint32_t> chunks, CpuArena& arena, ChunkVertices& vertices);

 private:
  // Patches [first, last) of one box and one chunk. Their points begin at first_point of the chunk.
  struct Run {
    size_t first, last, first_point, chunk_points;
    std::span<uint8_t> vertices;  // of the chunk
  };

  void NeedFeatures(uint32_t chunk);
  void EvaluateChunk(uint32_t chunk, ChunkVertices& vertices, fused::RunBuffer& buffer) const;
  void EvaluateRun(const Run& run, fused::RunBuffer& buffer) const;
  void FillPatches(const Run& run, fused::RunBuffer& buffer) const;
  void TakeFeatures(const Run& run, std::span<const size_t> first_points,
                    fused::RunBuffer& buffer) const;
  void ReplaceWeakNormals(const Run& run, std::span<const size_t> first_points,
                          fused::RunBuffer& buffer) const;
  void Write(const Run& run, fused::RunBuffer& buffer) const;
  void WriteQuantised(const Run& run, fused::RunBuffer& buffer) const;

  const fused::FusedPlan& plan_;
  const ViewSpec& spec_;
  const Input input_;
  fused::FrameBoxes& boxes_;
  fused::FeaturePoints features_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_ADAPTIVE_POINTS_H_

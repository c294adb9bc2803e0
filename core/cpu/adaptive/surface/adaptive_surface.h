// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What an evaluation with a tolerance asks of a pipeline on the CPU: bounds of patches, and the points of patterns.
//
//   Begin    an evaluation begins. The control points stay valid until its Write
//   Bound    of the patches of `chunks`, and of others if that costs nothing
//   Write    the vertices of `chunks` with the patterns of `codes` (PatternKey::Code of each patch of the plan)
//
// The bounds of a patch depend on the control points alone, so that those of a second Bound are the same.
//
// Errors   those of the pipeline's kernels
// Threads  one thread at a time; uses those of the arena
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_ADAPTIVE_SURFACE_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_ADAPTIVE_SURFACE_H_

#include <cstdint>
#include <span>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/adaptive/patch_curvature.h"
#include "core/backend.h"
#include "core/cpu/adaptive/surface/chunk_vertices.h"

namespace latticed {

class AdaptiveSurface {
 public:
  // Takes the bounds of one patch. Called from the arena's threads, once per patch.
  using Take = absl::FunctionRef<void(size_t patch, const CurvatureBounds<float>& bounds)>;

  virtual ~AdaptiveSurface() = default;

  virtual void Begin(std::span<const Vec3d> control_points) = 0;
  [[nodiscard]] virtual absl::Status Bound(std::span<const uint32_t> chunks, Take take) = 0;
  [[nodiscard]] virtual absl::Status Write(std::span<const uint32_t> chunks,
                                           std::span<const uint16_t> codes,
                                           const QuantisationBox& box, ChunkVertices& vertices) = 0;

  // By box, for slices of a plan: what bounds need to know of other slices. Empty if they need nothing.
  virtual std::span<Vec3d> reach() { return {}; }
  [[nodiscard]] virtual size_t MemoryBytes() const = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_ADAPTIVE_SURFACE_H_

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/surface/fused_surface.h"

#include "core/cpu/adaptive/surface/adaptive_points.h"

namespace latticed {

void FusedSurface::Begin(std::span<const Vec3d> control_points) {
  control_points_ = control_points;
  boxes_.emplace(*plan_, control_points);
}

absl::Status FusedSurface::Bound(std::span<const uint32_t> chunks, Take take) {
  bounder_.Bound(chunks, control_points_, *boxes_, take);
  return absl::OkStatus();
}

absl::Status FusedSurface::Write(std::span<const uint32_t> chunks, std::span<const uint16_t> codes,
                                 const QuantisationBox& box, ChunkVertices& vertices) {
  AdaptivePoints(*plan_, spec_, {control_points_, box, codes}, *boxes_)
      .Evaluate(chunks, arena_, vertices);
  boxes_.reset();
  return absl::OkStatus();
}

}  // namespace latticed

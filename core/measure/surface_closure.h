// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether the deformed surface encloses a volume.
//
//   border edge   an edge of the mesh that its faces do not run along equally often in both directions: it has one face
//                 only, or faces that are oriented against each other. Vertices at one position are one, if their
//                 weights are equal.
//   torn edge     an edge of a patch on a seam that is not attached (deform_plan.h): the two sides part there
//
// Errors   CheckClosed: kFailedPrecondition OPEN_SURFACE with both counts
// Threads  pure functions
#ifndef LATTICED_CORE_MEASURE_SURFACE_CLOSURE_H_
#define LATTICED_CORE_MEASURE_SURFACE_CLOSURE_H_

#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

[[nodiscard]] uint64_t CountBorderEdges(const PolygonMesh& mesh,
                                        const VertexWeights& weights = nullptr);
[[nodiscard]] uint64_t CountTornEdges(const DeformPlan& plan,
                                      std::span<const Vec3d> control_points);
[[nodiscard]] absl::Status CheckClosed(uint64_t border_edges, uint64_t torn_edges);

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_SURFACE_CLOSURE_H_

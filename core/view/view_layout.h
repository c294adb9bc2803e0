// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The layout and the writer of core/view/vertex_layout.h for a plan, a view's spec and a box.
//
// Threads  pure functions
#ifndef LATTICED_CORE_VIEW_VIEW_LAYOUT_H_
#define LATTICED_CORE_VIEW_VIEW_LAYOUT_H_

#include "core/backend.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/view/vertex_layout.h"

namespace latticed {

// The bits of the grid that positions are rounded to, as PointError takes them: 0 for floats.
[[nodiscard]] inline int GridBits(const ViewSpec& spec) {
  return spec.format == VertexFormat::kQuantised ? spec.position_bits : 0;
}

[[nodiscard]] inline VertexShape ShapeOf(const DeformPlan& plan, const ViewSpec& spec) {
  const bool normals = spec.normals != NormalMode::kNone;
  return {.patches = plan.patches.size(),
          .points_per_patch = static_cast<size_t>(PointsPerPatch(spec.segments)),
          .bytes_per_point = BytesPerPoint(spec),
          .quantised = spec.format == VertexFormat::kQuantised,
          .normal_bits = normals ? spec.normal_bits : 0};
}

[[nodiscard]] inline VertexLayout MakeVertexLayout(const DeformPlan& plan, const ViewSpec& spec) {
  return VertexLayout(ShapeOf(plan, spec));
}

[[nodiscard]] inline VertexWriter MakeVertexWriter(const DeformPlan& plan, const ViewSpec& spec,
                                                   const QuantisationBox& box) {
  const double scale = 1.0 / box.step(spec.position_bits);
  return {ShapeOf(plan, spec), scale, (-scale) * (box.origin - plan.local_origin),
          static_cast<double>((uint32_t{1} << spec.position_bits) - 1)};
}

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_VIEW_LAYOUT_H_

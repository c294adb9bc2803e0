// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/copy_shared_points.h"

#include "core/ffd/direct_ffd.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

constexpr size_t kCopiesPerTask = 2'048;  // about 100 us

}  // namespace

void CopySharedPoints(const SharedPoints& shared, const DeformPlan& plan,
                      std::span<const Vec3d> control_points, const VertexLayout& layout,
                      const VertexWriter& writer, int segments, std::span<uint8_t> vertices,
                      CpuArena& arena) {
  const std::vector<bool> attached = AttachedSeams(plan, control_points);
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  const auto s = static_cast<size_t>(segments);
  const auto copy_one = [&](const SharedCopy& copy) {
    const auto from = layout.Place(vertices.data(), copy.from_patch);
    const auto to = layout.Place(vertices.data(), copy.to_patch);
    if (copy.from_slot < kFirstEdgeSlot) {
      layout.CopyPosition(from, pattern.edge_points[copy.from_slot][0], to,
                          pattern.edge_points[copy.to_slot][0]);
      return;
    }
    const auto& source = pattern.edge_points[copy.from_slot - size_t{kFirstEdgeSlot}];
    const auto& target = pattern.edge_points[copy.to_slot - size_t{kFirstEdgeSlot}];
    for (size_t k = 1; k < s; ++k) {
      layout.CopyPosition(from, source[copy.reversed ? s - k : k], to, target[k]);
    }
  };
  const auto evaluate_one = [&](const SharedPoints::Orphan& orphan) {
    const auto to = layout.Place(vertices.data(), orphan.use.patch);
    const auto write = [&](uint32_t box, Vec3d parameter, size_t point) {
      const Vec3d world =
          EvaluateVolume(plan.structure, control_points, plan.boxes[box].span, parameter).position;
      writer.WritePosition(to, point, world - plan.local_origin);
    };
    if (orphan.use.slot < kFirstEdgeSlot) {
      const PlanVertex& vertex = plan.vertices[orphan.entity];
      write(vertex.box, vertex.parameter, pattern.edge_points[orphan.use.slot][0]);
      return;
    }
    const PlanEdge& edge = plan.edges[orphan.entity];
    const Vec3d a = plan.vertices[edge.vertex[0]].parameter;
    const Vec3d b = plan.vertices[edge.vertex[1]].parameter;
    const auto& target = pattern.edge_points[orphan.use.slot - size_t{kFirstEdgeSlot}];
    for (size_t k = 1; k < s; ++k) {
      const double t = static_cast<double>(k) / static_cast<double>(s);
      write(edge.box, (1 - t) * a + t * b, target[orphan.use.reversed ? s - k : k]);
    }
  };
  const auto copy_all = [&](size_t count, const auto& body) {
    arena.ForEach(count, body, kCopiesPerTask);
  };
  copy_all(shared.always().size(), [&](size_t i) { copy_one(shared.always()[i]); });
  copy_all(shared.when_attached().size(), [&](size_t i) {
    if (attached[shared.when_attached()[i].seam]) copy_one(shared.when_attached()[i].copy);
  });
  copy_all(shared.when_detached().size(), [&](size_t i) {
    if (!attached[shared.when_detached()[i].seam]) copy_one(shared.when_detached()[i].copy);
  });
  copy_all(shared.orphans().size(), [&](size_t i) {
    if (shared.orphans()[i].seam == kNoIndex || !attached[shared.orphans()[i].seam])
      evaluate_one(shared.orphans()[i]);
  });
}

}  // namespace latticed

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/device_plan.h"

#include <array>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "cuda/plan/pack_patches.h"
#include "cuda/plan/upload_table.h"

namespace latticed {
namespace {

// The device reads no absolute world position, so that it need not subtract what it does not know.
std::vector<kernels::DeviceVertex> PackVertices(const DeformPlan& plan) {
  std::vector<kernels::DeviceVertex> packed;
  packed.reserve(plan.vertices.size());
  for (const PlanVertex& v : plan.vertices) {
    packed.push_back({v.parameter, v.world - plan.local_origin});
  }
  return packed;
}

std::vector<kernels::CornerNormals> InterpolateNormals(const DeformPlan& plan) {
  const DirectFfd direct(plan, {});
  std::vector<kernels::CornerNormals> normals(plan.patches.size());
  for (size_t p = 0; p < normals.size(); ++p) {
    for (size_t c = 0; c < 3; ++c) {
      std::array<double, 3> b{};
      b[c] = 1;
      normals[p].corner[c] = ToFloat(direct.RestSmoothNormal(p, b));
    }
  }
  return normals;
}

}  // namespace

absl::StatusOr<std::shared_ptr<DevicePlan>> DevicePlan::Create(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
    std::shared_ptr<CudaContext> context) {
  std::shared_ptr<DevicePlan> result(new DevicePlan(std::move(plan), std::move(context)));
  absl::Status status = result->UploadGeometry(pipeline);
  status.Update(result->context_->stream().Synchronize("the plan"));
  if (!status.ok()) return status;
  result->FillTables();
  return result;
}

absl::Status DevicePlan::UploadGeometry(Pipeline pipeline) {
  const DeformPlan& plan = *plan_;
  std::vector<double> knots;
  for (const auto& axis : plan.structure.knots) knots.insert(knots.end(), axis.begin(), axis.end());
  if (auto s = UploadTable(*context_, knots, knots_); !s.ok()) return s;
  if (auto s = UploadTable(*context_, PackVertices(plan), vertices_); !s.ok()) return s;

  std::vector<kernels::DeviceBox> boxes;
  boxes.reserve(plan.boxes.size());
  for (const KnotBox& b : plan.boxes) boxes.push_back({{b.span[0], b.span[1], b.span[2], 0}});
  if (auto s = UploadTable(*context_, boxes, boxes_); !s.ok()) return s;

  const DirectFfd direct(plan, {});
  std::vector<kernels::PackedDirection> normals;
  normals.reserve(plan.patches.size());
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    normals.push_back(kernels::PackDirection(direct.RestFacetNormal(p)));
  }
  if (auto s = UploadTable(*context_, normals, facet_normals_); !s.ok()) return s;
  const auto packed = PackPatches(plan);
  if (!packed.ok()) return packed.status();
  if (auto s = UploadTable(*context_, packed->patches, patches_); !s.ok()) return s;
  if (pipeline != Pipeline::kFused) {
    auto shared = DeviceSharedPoints::Create(plan, *context_);
    if (!shared.ok()) return shared.status();
    shared_points_ = *std::move(shared);
    return absl::OkStatus();
  }
  auto fused = DeviceBoxes::Create(plan_, *context_, packed->seam_uses);
  if (!fused.ok()) return fused.status();
  fused_ = *std::move(fused);
  return absl::OkStatus();
}

void DevicePlan::FillTables() {
  const LatticeStructure& s = plan_->structure;
  const FrameMap map(s);
  const double* knots = knots_.data();
  for (size_t a = 0; a < 3; ++a) {
    tables_.degree[a] = s.degree[a];
    tables_.size[a] = s.size[a];
    tables_.knots[a] = knots;
    knots += s.knots[a].size();
    Vec3d axis;
    axis[static_cast<int>(a)] = 1;
    tables_.parameter_by_world[a] = map.DirectionToParameter(axis);
  }
  tables_.outside_box = plan_->outside_box();
  tables_.patches = patches_.data();
  tables_.vertices = vertices_.data();
  tables_.boxes = boxes_.data();
  tables_.facet_normals = facet_normals_.data();
}

absl::StatusOr<kernels::PlanTables> DevicePlan::Tables(bool smooth) {
  kernels::PlanTables tables = tables_;
  if (!smooth) return tables;
  tables.corner_normals = CornerNormalsNow();
  if (tables.corner_normals != nullptr) return tables;
  // Uploaded without the lock: who asks for MemoryBytes does not wait for it.
  DeviceBuffer<kernels::CornerNormals> made;
  absl::Status status = UploadTable(*context_, InterpolateNormals(*plan_), made);
  status.Update(context_->stream().Synchronize("the plan's normals"));
  if (!status.ok()) return status;
  const std::scoped_lock lock(mutex_);
  if (corner_normals_.size() == 0) corner_normals_ = std::move(made);
  tables.corner_normals = corner_normals_.data();
  return tables;
}

const kernels::CornerNormals* DevicePlan::CornerNormalsNow() const {
  const std::scoped_lock lock(mutex_);
  return corner_normals_.data();
}

size_t DevicePlan::MemoryBytes() const {
  const std::scoped_lock lock(mutex_);
  return knots_.size_bytes() + patches_.size_bytes() + vertices_.size_bytes() +
         boxes_.size_bytes() + facet_normals_.size_bytes() + corner_normals_.size_bytes() +
         (shared_points_.has_value() ? shared_points_->MemoryBytes() : 0) +
         (fused_.has_value() ? fused_->MemoryBytes() : 0);
}

}  // namespace latticed

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/device_plan.h"

#include <array>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/ffd/box/box_basis.h"
#include "core/ffd/direct_ffd.h"
#include "cuda/plan/lattice_part.h"
#include "cuda/plan/pack_patches.h"
#include "cuda/plan/pack_shared_points.h"

namespace latticed {
namespace {

constexpr char kPlanPurpose[] = "plan";

// All world positions on the device are relative to the local origin.
std::vector<kernels::DeviceVertex> PackVertices(const DeformPlan& plan) {
  std::vector<kernels::DeviceVertex> packed;
  packed.reserve(plan.vertices.size());
  for (const PlanVertex& v : plan.vertices) {
    packed.push_back({v.parameter, v.world - plan.local_origin});
  }
  return packed;
}

std::vector<kernels::DeviceBox> PackSpans(const DeformPlan& plan) {
  std::vector<kernels::DeviceBox> packed;
  packed.reserve(plan.boxes.size());
  for (const KnotBox& b : plan.boxes) packed.push_back({{b.span[0], b.span[1], b.span[2], 0}});
  return packed;
}

std::vector<kernels::PackedDirection> PackFacetNormals(const DeformPlan& plan) {
  const DirectFfd direct(plan, {});
  std::vector<kernels::PackedDirection> packed;
  packed.reserve(plan.patches.size());
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    packed.push_back(kernels::PackDirection(direct.RestFacetNormal(p)));
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

std::vector<Vec3d> PackGradients(const DeformPlan& plan) {
  std::vector<Vec3d> gradients;
  gradients.reserve(plan.patches.size());
  for (size_t p = 0; p < plan.patches.size(); ++p) gradients.push_back(plan.PatchWeightGradient(p));
  return gradients;
}

std::vector<Vec3d> PackIdentity(const DeformPlan& plan) {
  std::vector<Vec3d> points = plan.identity_points;
  for (Vec3d& p : points) p -= plan.local_origin;
  return points;
}

std::vector<kernels::RestBox> PackRestBoxes(const std::shared_ptr<const DeformPlan>& plan) {
  const BoxBasis basis(plan);
  const FrameMap map(plan->structure);
  std::vector<kernels::RestBox> boxes;
  for (uint32_t b = 0; b < plan->boxes.size(); ++b) {
    const Vec3d centre = basis.Centre(b);
    const Vec3d world = b == plan->outside_box() ? centre : map.ToWorld(centre);
    // The inverse of the gradients.
    const std::array<Vec3d, 3> row = basis.Gradients(b);
    const double volume = Dot(row[0], Cross(row[1], row[2]));
    boxes.push_back(
        {.centre = world - plan->local_origin,
         .by_coordinate = {Cross(row[1], row[2]) / volume, Cross(row[2], row[0]) / volume,
                           Cross(row[0], row[1]) / volume}});
  }
  return boxes;
}

std::vector<kernels::FusedBox> PackBoxes(const DeformPlan& plan, const BoxBasis& basis) {
  std::vector<kernels::FusedBox> boxes;
  boxes.reserve(plan.boxes.size());
  for (uint32_t b = 0; b < plan.boxes.size(); ++b) {
    const Vec3d width = basis.Width(b);
    const std::array<Vec3d, 3> gradients = basis.Gradients(b);
    // The device knows world positions relative to the local origin.
    const Vec3d origin = b == plan.outside_box() ? plan.local_origin : Vec3d{};
    boxes.push_back({.centre = basis.Centre(b) - origin,
                     .inverse_width = {1 / width.x, 1 / width.y, 1 / width.z},
                     .gradient = {gradients[0], gradients[1], gradients[2]}});
  }
  return boxes;
}

// Tables of the fused kernels alone. A patch takes 8 bytes (feature_uses.h), a box 120, a knot span
// 128 (the matrix of core/ffd/box/box_basis.h), a corner or edge on a seam 8. The pointers of `tables`
// are set when `upload` is sent.
void AddBoxes(const std::shared_ptr<const DeformPlan>& plan,
              const std::vector<kernels::SeamUse>& seam_uses, TableUpload& upload,
              kernels::FusedTables& tables) {
  const BoxBasis basis(plan);
  const std::array<uint32_t, 3> strides = BoxStrides(plan->structure);
  for (size_t i = 0; i < 3; ++i) {
    tables.axis[i] = basis.axes()[i];
    tables.degree[i] = basis.degree()[i];
    tables.box_stride[i] = strides[i];
    std::vector<double> numbers;
    for (const BoxBasis::Matrix& matrix : basis.matrices(i)) {
      for (const auto& row : matrix) numbers.insert(numbers.end(), row.begin(), row.end());
    }
    upload.Add(numbers, tables.basis[i]);
  }
  tables.box_count = static_cast<uint32_t>(plan->boxes.size());
  tables.seam_use_count = static_cast<uint32_t>(seam_uses.size());
  upload.Add(PackBoxes(*plan, basis), tables.boxes);
  upload.Add(seam_uses, tables.seam_uses);
  upload.Add(PackFeatureUses(*plan), tables.feature_uses);
}

// Tables of the pipelines that evaluate every patch by itself: the owners of the positions of
// corners and edges, about 10 bytes a patch (pack_shared_points.h).
void AddSharedPoints(const DeformPlan& plan, TableUpload& upload,
                     kernels::SharedPointTables& tables) {
  const PackedSharedPoints packed = PackSharedPoints(plan);
  tables.patch_count = plan.patches.size();
  tables.on_seams_count = packed.on_seams.size();
  tables.orphan_count = packed.orphans.size();
  upload.Add(packed.vertex_owners, tables.vertex_owners);
  upload.Add(packed.edge_begins, tables.edge_begins);
  upload.Add(packed.edge_owners, tables.edge_owners);
  upload.Add(packed.edge_uses, tables.edge_uses);
  upload.Add(packed.on_seams, tables.on_seams);
  upload.Add(packed.orphans, tables.orphans);
}

// Fills degree, size, knots and parameter_by_world of the tables of a lattice.
template <class Tables>
void AddLattice(const LatticeStructure& s, TableUpload& upload, Tables& tables) {
  const std::array<Vec3d, 3> parameter_by_world = ParameterByWorld(s);
  for (size_t a = 0; a < 3; ++a) {
    tables.degree[a] = s.degree[a];
    tables.size[a] = s.size[a];
    upload.Add(s.knots[a], tables.knots[a]);
    tables.parameter_by_world[a] = parameter_by_world[a];
  }
}

void AddTurned(const DeformPlan& plan, TableUpload& upload, kernels::TurnedTables& tables) {
  for (const TurnedLattice& lattice : plan.turned) {
    kernels::TurnedTable& table = tables.lattices[tables.count++];
    AddLattice(lattice.structure, upload, table);
    table.first_point = lattice.first_point;
    upload.Add(lattice.parameters, table.parameters);
    std::vector<kernels::DeviceBox> spans;
    spans.reserve(lattice.spans.size());
    for (const KnotSpans& s : lattice.spans) spans.push_back({{s[0], s[1], s[2], 0}});
    upload.Add(std::move(spans), table.spans);
  }
}

}  // namespace

absl::StatusOr<std::shared_ptr<DevicePlan>> DevicePlan::Create(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
    std::shared_ptr<CudaContext> context) {
  const CudaStream& stream = context->stream();
  std::shared_ptr<DevicePlan> result(new DevicePlan(std::move(plan), std::move(context)));
  TableUpload upload;
  LATTICED_RETURN_IF_ERROR(result->AddTables(pipeline, upload));
  LATTICED_ASSIGN_OR_RETURN(result->block_,
                            upload.Send(result->context_->memory(), kPlanPurpose, stream.get()));
  LATTICED_RETURN_IF_ERROR(stream.Synchronize("the plan"));
  return result;
}

absl::Status DevicePlan::AddTables(Pipeline pipeline, TableUpload& upload) {
  const DeformPlan& plan = *plan_;
  AddLattice(plan.structure, upload, tables_);
  tables_.outside_box = plan.outside_box();
  LATTICED_ASSIGN_OR_RETURN(auto packed, PackPatches(plan));
  upload.Add(std::move(packed.patches), tables_.patches);
  upload.Add(PackVertices(plan), tables_.vertices);
  upload.Add(PackSpans(plan), tables_.boxes);
  upload.Add(PackFacetNormals(plan), tables_.facet_normals);
  if (plan.is_weighted()) {
    upload.Add(plan.vertex_weights, tables_.weights.vertices);
    upload.Add(PackGradients(plan), tables_.weights.gradients);
  }
  if (pipeline == Pipeline::kFused) {
    if (plan.is_weighted()) {
      upload.Add(PackIdentity(plan), tables_.weights.identity_points);
      upload.Add(PackRestBoxes(plan_), tables_.weights.boxes);
    }
    AddBoxes(plan_, packed.seam_uses, upload, fused_tables_);
    if (LatticePart::IsWorthwhile(plan.structure))
      chunk_needs_ = std::make_shared<const ChunkNeeds>(plan);
  } else {
    AddSharedPoints(plan, upload, shared_points_);
    AddTurned(plan, upload, turned_);
  }
  return absl::OkStatus();
}

uint64_t DevicePlan::BytesToCome(bool smooth) const {
  const bool all_here = !smooth || CornerNormalsNow() != nullptr;
  return all_here ? 0 : plan_->patches.size() * sizeof(kernels::CornerNormals);
}

absl::StatusOr<kernels::PlanTables> DevicePlan::Tables(bool smooth, DeviceReservation& from) {
  kernels::PlanTables tables = tables_;
  if (!smooth) return tables;
  tables.corner_normals = CornerNormalsNow();
  if (tables.corner_normals != nullptr) return tables;
  // Uploaded without the lock, so that MemoryBytes does not wait.
  auto made = UploadNormals(from);
  // These bytes stay in the plan, or are free at once where another copy is kept; a later refusal
  // frees none of them.
  if (made.ok()) from.LeaveBehind(made->size_bytes());
  const MutexLock lock(&mutex_);
  // Checked before an error is returned: another call's copy may have taken the memory.
  if (corner_normals_.size() == 0) {
    if (!made.ok()) return made.status();
    corner_normals_ = *std::move(made);
  }
  tables.corner_normals = corner_normals_.data();
  return tables;
}

absl::StatusOr<DeviceBuffer<kernels::CornerNormals>> DevicePlan::UploadNormals(
    DeviceReservation& from) const {
  const CudaStream& stream = context_->stream();
  auto made = DeviceBuffer<kernels::CornerNormals>::Upload(
      from, kPlanPurpose, InterpolateNormals(*plan_), stream.get());
  if (!made.ok()) return made;
  LATTICED_RETURN_IF_ERROR(stream.Synchronize("the plan's normals"));
  return made;
}

const kernels::CornerNormals* DevicePlan::CornerNormalsNow() const {
  const MutexLock lock(&mutex_);
  return corner_normals_.data();
}

size_t DevicePlan::MemoryBytes() const {
  const MutexLock lock(&mutex_);
  return block_.size_bytes() + corner_normals_.size_bytes();
}

size_t DevicePlan::HostMemoryBytes() const {
  return chunk_needs_ == nullptr ? 0 : chunk_needs_->MemoryBytes();
}

}  // namespace latticed

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/device_boxes.h"

#include <array>
#include <utility>

#include "core/ffd/box_basis.h"
#include "cuda/plan/pack_patches.h"
#include "cuda/plan/upload_table.h"

namespace latticed {
namespace {

using kernels::FusedBox;

std::vector<FusedBox> PackBoxes(const DeformPlan& plan, const BoxBasis& basis) {
  std::vector<FusedBox> boxes;
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

}  // namespace

absl::StatusOr<DeviceBoxes> DeviceBoxes::Create(const std::shared_ptr<const DeformPlan>& plan,
                                                CudaContext& context,
                                                const std::vector<kernels::SeamUse>& seam_uses) {
  const BoxBasis basis(plan);
  std::vector<double> numbers;
  std::array<size_t, 3> begin{};
  for (size_t i = 0; i < 3; ++i) {
    begin[i] = numbers.size();
    for (const BoxBasis::Matrix& matrix : basis.matrices(i)) {
      for (const auto& row : matrix) numbers.insert(numbers.end(), row.begin(), row.end());
    }
  }
  DeviceBoxes result;
  const std::vector<FusedBox> boxes = PackBoxes(*plan, basis);
  absl::Status status = UploadTable(context, boxes, result.boxes_);
  if (status.ok()) status = UploadTable(context, numbers, result.basis_);
  if (status.ok()) status = UploadTable(context, seam_uses, result.seam_uses_);
  const std::vector<kernels::FeatureUses> feature_uses = PackFeatureUses(*plan);
  if (status.ok()) {
    status = UploadTable(context, feature_uses, result.feature_uses_);
  }
  if (!status.ok()) return status;

  kernels::FusedTables& tables = result.tables_;
  const std::array<uint32_t, 3> strides = BoxStrides(plan->structure);
  for (size_t i = 0; i < 3; ++i) {
    tables.axis[i] = basis.axes()[i];
    tables.degree[i] = basis.degree()[i];
    tables.box_stride[i] = strides[i];
    tables.basis[i] = result.basis_.data() + begin[i];
  }
  tables.box_count = static_cast<uint32_t>(boxes.size());
  tables.boxes = result.boxes_.data();
  tables.seam_uses = result.seam_uses_.data();
  tables.feature_uses = result.feature_uses_.data();
  tables.seam_use_count = static_cast<uint32_t>(seam_uses.size());
  return result;
}

}  // namespace latticed

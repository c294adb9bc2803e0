// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/device_boxes.h"

#include <array>

#include "core/ffd/box_basis.h"
#include "cuda/plan/pack_patches.h"

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

}  // namespace latticed

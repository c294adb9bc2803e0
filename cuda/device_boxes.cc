// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device_boxes.h"

#include <span>
#include <utility>

#include "core/ffd/box_basis.h"
#include "cuda/pack_patches.h"

namespace latticed {
namespace {

using kernels::FusedBox;

constexpr char kPurpose[] = "plan";

template <typename T>
absl::Status Upload(CudaContext& context, std::span<const T> from, DeviceBuffer<T>& to) {
  auto buffer =
      DeviceBuffer<T>::Upload(context.memory(), kPurpose, from, context.stream().get());
  if (!buffer.ok()) return buffer.status();
  to = *std::move(buffer);
  return absl::OkStatus();
}

std::vector<FusedBox> PackBoxes(const DeformPlan& plan, const BoxBasis& basis) {
  std::vector<FusedBox> boxes;
  boxes.reserve(plan.boxes.size());
  for (uint32_t b = 0; b < plan.boxes.size(); ++b) {
    // The device knows world positions relative to the local origin.
    const Vec3d origin = b == plan.outside_box() ? plan.local_origin : Vec3d{};
    const Vec3d width = basis.Width(b);
    boxes.push_back({basis.Centre(b) - origin, {1 / width.x, 1 / width.y, 1 / width.z}});
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
  absl::Status status = Upload<FusedBox>(context, boxes, result.boxes_);
  if (status.ok()) status = Upload<double>(context, numbers, result.basis_);
  if (status.ok()) status = Upload<kernels::SeamUse>(context, seam_uses, result.seam_uses_);
  const std::vector<kernels::FeatureUses> feature_uses = PackFeatureUses(*plan);
  if (status.ok()) {
    status = Upload<kernels::FeatureUses>(context, feature_uses, result.feature_uses_);
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

// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/resident_target.h"

#include "server/resident_view.h"

namespace latticed {

absl::StatusOr<std::unique_ptr<DeformView>> ResidentTarget::CreateView(const ViewSpec& spec) {
  auto made = residency_->Run([&] { return inner_->CreateView(spec); });
  if (!made.ok()) return made.status();
  return std::make_unique<ResidentView>(residency_, *std::move(made));
}

absl::StatusOr<std::vector<double>> ResidentTarget::ControlNets(
    std::span<const Vec3d> control_points, size_t first, size_t last) {
  return residency_->Run([&] { return inner_->ControlNets(control_points, first, last); });
}

}  // namespace latticed

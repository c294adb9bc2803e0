// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/resident_target.h"

#include <utility>

#include "core/base/status_macros.h"
#include "server/engine/render/resident_view.h"

namespace latticed {

ResidentTarget::ResidentTarget(Residency* residency, std::shared_ptr<const DeformPlan> plan,
                               std::shared_ptr<DeformTarget> inner)
    : residency_(residency),
      plan_(std::move(plan)),
      pipeline_(inner->pipeline()),
      on_device_(inner->evaluates_on_device()),
      last_use_(residency->NextUse()),
      inner_(std::move(inner)) {}

absl::StatusOr<std::shared_ptr<DeformTarget>> ResidentTarget::Inner() {
  Touch();
  {
    const MutexLock lock(&mutex_);
    if (inner_ != nullptr) return inner_;
  }
  LATTICED_ASSIGN_OR_RETURN(auto made, residency_->PrepareInner(plan_, pipeline_));
  const MutexLock lock(&mutex_);
  if (inner_ == nullptr) inner_ = std::move(made);
  return inner_;
}

absl::StatusOr<std::unique_ptr<DeformView>> ResidentTarget::CreateView(const ViewSpec& spec) {
  LATTICED_ASSIGN_OR_RETURN(const auto inner, Inner());
  LATTICED_ASSIGN_OR_RETURN(auto made, residency_->Run([&] { return inner->CreateView(spec); }));
  return std::make_unique<ResidentView>(shared_from_this(), inner, std::move(made));
}

absl::StatusOr<std::vector<double>> ResidentTarget::ControlNets(
    std::span<const Vec3d> control_points, size_t first, size_t last) {
  LATTICED_ASSIGN_OR_RETURN(const auto inner, Inner());
  return residency_->Run([&] { return inner->ControlNets(control_points, first, last); });
}

std::shared_ptr<DeformTarget> ResidentTarget::InnerNow() const {
  const MutexLock lock(&mutex_);
  return inner_;
}

MemoryUse ResidentTarget::memory() const {
  const auto inner = InnerNow();
  return inner != nullptr ? inner->memory() : MemoryUse{{"plan", plan_->MemoryBytes()}};
}

uint64_t ResidentTarget::EncoderBytes(const ViewSpec& spec) const {
  const auto inner = InnerNow();
  return inner != nullptr ? inner->EncoderBytes(spec) : 0;
}

DeviceUse ResidentTarget::device_use() const {
  const auto inner = InnerNow();
  return inner != nullptr ? inner->device_use() : DeviceUse{};
}

bool ResidentTarget::GiveBack() {
  if (!on_device_) return false;
  std::shared_ptr<DeformTarget> given;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  if (inner_.use_count() != 1) return false;
  given.swap(inner_);
  return true;
}

}  // namespace latticed

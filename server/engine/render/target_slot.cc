// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/target_slot.h"

#include <utility>

namespace latticed {

TargetSlot::TargetSlot(RenderBackend* backend, std::shared_ptr<DeformTarget> target,
                       std::shared_ptr<const DeformPlan> plan, MemoryReservation reservation)
    : backend_(backend),
      plan_(std::move(plan)),
      pipeline_(target->pipeline()),
      on_device_(target->Traits({}).on_device),
      has_edge_bounds_(target->has_edge_bounds()),
      reservation_(std::move(reservation)),
      target_(std::move(target)) {}

absl::StatusOr<std::shared_ptr<DeformTarget>> TargetSlot::Get() {
  if (auto target = Now(); target != nullptr) return target;
  LATTICED_ASSIGN_OR_RETURN(auto made, backend_->Prepare(plan_, pipeline_));
  const MutexLock lock(&mutex_);
  if (target_ == nullptr) target_ = std::move(made);
  return target_;
}

std::shared_ptr<DeformTarget> TargetSlot::Now() const {
  const MutexLock lock(&mutex_);
  return target_;
}

MemoryUse TargetSlot::memory() const {
  const auto target = Now();
  return target != nullptr ? target->memory() : MemoryUse{{"plan", plan_->MemoryBytes()}};
}

uint64_t TargetSlot::BytesOn(int device, uint64_t bytes) const {
  const auto target = Now();
  const DeviceUse use = target != nullptr ? target->device_use() : DeviceUse{};
  uint64_t all = 0;
  for (const auto& [number, part] : use) all += part;
  const auto found = use.find(device);
  if (found == use.end() || all == 0) return 0;
  return static_cast<uint64_t>(static_cast<double>(bytes) * static_cast<double>(found->second) /
                               static_cast<double>(all));
}

bool TargetSlot::Evict() {
  if (!on_device_) return false;
  std::shared_ptr<DeformTarget> evicted;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  if (target_.use_count() != 1) return false;
  evicted.swap(target_);
  return true;
}

}  // namespace latticed
